"""What accuracy costs: the reference, where it is measured, errors, advice."""
