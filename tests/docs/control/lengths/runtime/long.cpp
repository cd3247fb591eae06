// Of these a method is too long, and the file.
namespace sandglass {
const int k_table[] = {
    1,
    2,
    3,
};
int first() { return k_table[0]; }
struct Counter {
  int count = 0;
  int next(int by) {  // the "}" of a comment or of a string is no brace
    const char* text = "}";
    const auto twice = [](int x) {
      x *= 2;
      return x;
    };
    count += twice(by) + text[0];
    return count;
  }
  int last() const { return count; }
};
#define OPENED {
int second(int a) {
  switch (a) {
    case '{':
      return 1;
    default:
      return 2;
  }
}
}  // namespace sandglass
