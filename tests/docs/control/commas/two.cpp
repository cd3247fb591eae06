// One fault, among commas that may stand.
template <class... Parts>
int sum(int from, Parts... parts) {
  int all = from, count = 0;
  for (int i = 0, j = 1; i < from; ++i, ++j) all += j;
  ((all += parts), ...);
  all = 2 * all, count = 1;
  return all + count;
}
