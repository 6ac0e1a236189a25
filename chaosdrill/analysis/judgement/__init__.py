"""Evidence from records, and the words that it earns."""
