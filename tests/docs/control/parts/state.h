// ---- Part (own.cpp)
struct Part {
  int count;
};
// ---- Rest (own.cpp)
struct State {
  Part part;
};
