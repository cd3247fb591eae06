// It refuses without a full stop.
int no(const char** reason) { return refuse(reason, "it is NULL: pass one"); }
