// Two lines
// where one may be.
