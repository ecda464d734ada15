"""Many runs of one structure side by side in vector registers: a lane each, with its own time and
step.
"""

from clearance.lanes.group import Answers as Answers
from clearance.lanes.group import Group as Group
from clearance.lanes.group import Points as Points
from clearance.lanes.group import impossible as impossible
