// Three rules of types.h, for one function at a time. From good arguments of it follow
//   - NULL for each of its pointers: functions with a status refuse it and name the argument; functions that return
//     nothing do nothing; functions that return a value return the neutral one. What the header calls optional is
//     accepted,
//   - every size of a struct that it fills: nothing beyond struct_size is written,
//   - a block in which it makes something: one too small or not aligned is refused, and nothing is touched; one of the
//     size announced suffices, and no byte outside is touched, in what follows neither.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/guarded_block.h"
#include "tests/package/filled_struct.h"

namespace sandglass::tests {

using test::GuardedBlock;

inline bool in_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

inline bool has_word(const char* said, std::string_view word) {
  const std::string sentence = said != nullptr ? said : "";
  for (size_t at = 0; (at = sentence.find(word, at)) != std::string::npos; ++at)
    if ((at == 0 || !in_word(sentence[at - 1])) && !in_word(sentence.c_str()[at + word.size()])) return true;
  return false;
}

// The arguments of each function that has a pointer among them: no more than header_facts.py lets it have.
struct Function {
  std::string_view name;
  std::string_view arguments[7];
};
inline constexpr Function k_functions[] = {
#include "arguments.inc"
};

// A function with its name.
#define NAMED(function) #function, function
#define MADE(type, block, desc_of) made<type>(block, desc_of, NAMED(type##_bytes), NAMED(type##_create))

// A call with arguments that may have changed since. It is of one type for all functions: what is of each one's own is compiled
// for each.
class Call {
 public:
  template <class Closure>
  explicit Call(Closure& closure)
      : closure_(&closure), call_([](void* at) { return (*static_cast<Closure*>(at))(); }) {}
  int operator()() const { return call_(closure_); }

 private:
  void* closure_;
  int (*call_)(void*);
};

// Where a pointer stands; null for anything else.
template <class T>
void* pointer_at(T** place) {
  return place;
}
inline void* pointer_at(const void*) { return nullptr; }

// Whether a struct says how large it is.
template <class T, class = void>
constexpr bool k_sized = false;
template <class T>
constexpr bool k_sized<T, std::void_t<decltype(static_cast<T*>(nullptr)->struct_size)>> = true;

// A struct that an app hands over to be filled.
template <class T>
T sized() {
  T empty = {};
  empty.struct_size = sizeof empty;
  return empty;
}

// Filled whole, or read and written: those are no answers to a struct_size.
inline bool fills_within_size(const std::string& name) {
  return name.find("_default") == std::string::npos && name != "sandglass_box_body" && name != "sandglass_room_fade" &&
         name != "sandglass_scene_frame";  // of that: owner_types_test.cpp
}

class Arguments : public ::testing::Test {
 protected:
  // A function with arguments of which only the NULL is wrong. `optional`: those that may be NULL. The argument
  // `reason`, which every function with a status has, is added.
  template <class R, class... P, class... A>
  void row(const char* name, R (*function)(P...), const char* optional, A... given) {
    constexpr bool k_refuses = (std::is_same_v<P, const char**> || ...);
    if constexpr (k_refuses && sizeof...(A) + 1 == sizeof...(P)) {
      row(name, function, optional, given..., &reason);
    } else {
      std::tuple<P...> arguments(given...);
      auto closure = [&]() -> int {
        if constexpr (std::is_void_v<R>) {
          std::apply(function, arguments);
          return 0;
        } else if constexpr (k_refuses) return std::apply(function, arguments);
        else return std::apply(function, arguments) != R{} ? 1 : 0;
      };
      const Call call(closure);
      SCOPED_TRACE(name);
      const std::array<void*, sizeof...(P)> pointers =
          std::apply([](auto&... each) { return std::array<void*, sizeof...(P)>{pointer_at(&each)...}; }, arguments);
      std::apply([&](auto&... each) { (struct_size(name, &each, k_refuses, call), ...); }, arguments);
      // The block stands before its size, the place for what is made before `reason`.
      if constexpr (sizeof...(P) > 4) {
        constexpr size_t k_made = sizeof...(P) - 2;
        using Types = std::tuple<P...>;
        if constexpr (std::is_same_v<std::tuple_element_t<k_made - 2, Types>, void*> &&
                      std::is_same_v<std::tuple_element_t<k_made - 1, Types>, uint64_t>)
          block_size(&std::get<k_made - 2>(arguments), &std::get<k_made - 1>(arguments), *std::get<k_made>(arguments),
                     call);
      }
      without_each(name, k_refuses, optional, pointers, call);
    }
  }

  // The same for one whose next argument is a struct to be filled.
  template <class R, class... P, class... A>
  void fills(const char* name, R (*function)(P...), A... given) {
    auto filled = sized<std::remove_pointer_t<std::tuple_element_t<sizeof...(A), std::tuple<P...>>>>();
    row(name, function, "", given..., &filled);
  }

  template <class T>
  void struct_size(const char* name, T** place, bool refuses, const Call& call) {
    if constexpr (!std::is_const_v<T> && k_sized<T>) {
      if (!fills_within_size(name)) return;
      T* const good = *place;
      const auto fill = [&](T* filled) {
        *place = filled;
        return call() == SANDGLASS_OK || !refuses;
      };
      expect_filled_within_its_size<T>(fill, refuses);
      *place = good;
      ++filled_;
    }
  }
  void struct_size(const char*, const void*, bool, const Call&) {}

  template <class Handle>
  void block_size(void** place, uint64_t* size, Handle* const& made, const Call& call) {
    const uint64_t announced = *size;
    void* const good = *place;
    Handle* const before = made;
    GuardedBlock block(announced);
    *place = block.data();
    for (uint64_t less = 1; less <= announced; less += less < 4 ? 1 : announced / 12) {
      *size = announced - less;
      EXPECT_EQ(call(), SANDGLASS_ERROR_MEMORY_TOO_SMALL) << less;
    }
    *size = 0;
    EXPECT_EQ(call(), SANDGLASS_ERROR_MEMORY_TOO_SMALL);
    *size = announced;
    for (size_t offset = 1; offset < SANDGLASS_BLOCK_ALIGNMENT; ++offset) {
      *place = block.data() + offset;
      EXPECT_EQ(call(), SANDGLASS_ERROR_MEMORY_ALIGNMENT) << offset;
    }
    EXPECT_TRUE(block.untouched());
    EXPECT_EQ(made, before);
    *place = block.data();
    EXPECT_EQ(call(), SANDGLASS_OK);
    EXPECT_TRUE(block.guards_intact());
    *place = good;
    ++blocks_;
  }

  void block_size(void**, uint64_t*, uint64_t, const Call&) {}  // saves bytes, and makes nothing

  // Calls once for each of the pointers, with that one NULL. The call returns a status, or whether a value is not 0.
  void without_each(const char* name, bool refuses, const char* optional, std::span<void* const> pointers,
                    const Call& call) {
    covered_.insert(name);
    const Function* const function = std::ranges::find(k_functions, std::string_view(name), &Function::name);
    ASSERT_NE(function, std::end(k_functions)) << name << " is not in the headers";
    ASSERT_EQ(static_cast<size_t>(std::ranges::find(function->arguments, "") - function->arguments), pointers.size())
        << name;
    for (size_t i = 0; i < pointers.size(); ++i) {
      if (pointers[i] == nullptr) continue;
      const std::string argument(function->arguments[i]);
      const bool accepted = has_word(optional, argument) || argument == "reason";
      void* good;
      std::memcpy(&good, pointers[i], sizeof good);
      std::memset(pointers[i], 0, sizeof good);
      reason = nullptr;
      const int returned = call();
      std::memcpy(pointers[i], &good, sizeof good);
      ++cases_;
      SCOPED_TRACE(std::string(name) + " without " + argument + (reason != nullptr ? reason : ""));
      if (!refuses) {
        EXPECT_TRUE(accepted || returned == 0);
        continue;
      }
      EXPECT_EQ(returned, accepted ? SANDGLASS_OK : SANDGLASS_ERROR_INVALID_ARGUMENT);
      EXPECT_TRUE(accepted || (has_word(reason, argument) && has_word(reason, "NULL")));
    }
  }

  // Fills the description; whether it is enough for creation.
  template <class Desc>
  bool is_made(Desc* desc_of, void (*fill)(Desc*), sandglass_status (*bytes_of)(const Desc*, uint64_t*, const char**)) {
    fill(desc_of);
    return bytes_of(desc_of, &need, nullptr) == SANDGLASS_OK;
  }

  // What good arguments make in the block, by rows of the two functions that lead there.
  template <class Handle, class Desc>
  Handle* made(GuardedBlock* block, Desc* desc_of, const char* bytes_name,
               sandglass_status (*bytes_of)(const Desc*, uint64_t*, const char**), const char* create_name,
               sandglass_status (*create)(const Desc*, void*, uint64_t, Handle**, const char**)) {
    row(bytes_name, bytes_of, "", desc_of, &need);
    EXPECT_EQ(bytes_of(desc_of, &need, nullptr), SANDGLASS_OK);
    *block = GuardedBlock(need);
    Handle* handle = nullptr;
    row(create_name, create, "", desc_of, block->data(), need, &handle);
    EXPECT_NE(handle, nullptr);
    return handle;
  }

  void SetUp() override {
    desc = scene_desc();
    desc.granular.particle_capacity = desc.granular.grain_capacity = desc.granular.boundary_capacity = 64;
    desc.granular.body_capacity = 8;
    desc.granular.body_particle_capacity = 32;
    ASSERT_TRUE(scene.create(desc));
    ASSERT_EQ(sandglass_scene_bytes(&desc, &bytes, nullptr), SANDGLASS_OK);
    spare = allocate_block(bytes);
  }

  // A file in words, as the library wants it aligned.
  static std::vector<uint64_t> file_of(const std::string& path, uint64_t* bytes) {
    *bytes = std::filesystem::file_size(path);
    std::vector<uint64_t> words(*bytes / 8 + 1);
    std::ifstream(path, std::ios::binary)
        .read(reinterpret_cast<char*>(words.data()), static_cast<std::streamsize>(*bytes));
    return words;
  }

  void made_from_defaults();
  void scenes();
  void sampling();
  void fields();
  void lights();
  void rooms();
  void reliefs();
  void shadows();
  void casts();
  void pile_shadows();
  void skins();

  std::set<std::string> covered_;
  int cases_ = 0, filled_ = 0, blocks_ = 0;

  sandglass_scene_desc desc;
  Scene scene;
  uint64_t bytes = 0, need = 0;
  uint32_t count = 0, other = 0;
  int32_t taken = 0;
  const char* reason = nullptr;
  Block spare;
  float point[4] = {0.0f, 0.5f, 0.0f, 1.0f}, low[3] = {-0.1f, -0.1f, -0.1f}, high[3] = {0.1f, 0.1f, 0.1f};
};

}  // namespace sandglass::tests
