from clearance.results.record import PressureFields as PressureFields
from clearance.results.record import Record as Record
from clearance.results.result import Result as Result
from clearance.results.result import open_result as open_result
