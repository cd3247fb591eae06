/* What every program weighs: subtracted from the others. */
int main(void) { return 0; }
