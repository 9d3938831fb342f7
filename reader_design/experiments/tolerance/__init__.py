"""What build errors do to a reader: samples, yield, sensitivities, confidence of a ranking."""
