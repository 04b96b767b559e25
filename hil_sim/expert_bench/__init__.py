"""A bank of questions with known answers, and how well the experts and their consensus do on it."""
