"""From records to parameters, of mechanisms and of ball joints; from limits to dimensions."""
