"""A recorded drive fed through the same code again."""
