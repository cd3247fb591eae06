/* An empty program, whose size is subtracted from the others. */
int main(void) { return 0; }
