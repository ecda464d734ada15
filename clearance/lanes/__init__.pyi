from clearance.lanes.group import Answers as Answers
from clearance.lanes.group import Group as Group
from clearance.lanes.group import Points as Points
from clearance.lanes.group import impossible as impossible
