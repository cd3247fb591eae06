void take(State* whole);
void change(Part* part, const State& s) {
  part->count += s.part.count;
  ++part->count;
}
void read(const Part* part, int* out) { *out = part->count; }
