"""What one record says: exponents and their vectors, dimensions, regularity, and how long chaos lasts."""
