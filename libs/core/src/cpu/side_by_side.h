#pragma once
#include "kernels/math.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

// Loops that are worth it are compiled for several generations of processors. All give the same
// bits: IEEE operations have one result, in vectors too, and nothing is contracted.

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__gnu_linux__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(TALUS_ONE_CLONE)
#define TALUS_CLONES \
  __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"), flatten))
#else
#define TALUS_CLONES __attribute__((flatten))
#endif

/** The iterations of the next loop touch different memory. */
#if defined(__clang__)
#define TALUS_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define TALUS_INDEPENDENT _Pragma("GCC ivdep")
#endif

/** For functions that only fetch memory: a compiler sees no effect and would drop the calls. */
#define TALUS_FETCHES [[gnu::always_inline]] inline

namespace talus
{
/** Any value, to try how many fields a structure has. */
struct AnyValue
{
  template <class T>
  operator T() const;
};
template <class T, class Which, class = void>
constexpr bool kTakesValues = false;
template <class T, std::size_t... i>
constexpr bool kTakesValues<
    T, std::index_sequence<i...>, std::void_t<decltype(T{(static_cast<void>(i), AnyValue{})...})>> =
    true;
template <class T, std::size_t n = 1>
constexpr std::size_t count_fields()
{
  if constexpr (kTakesValues<T, std::make_index_sequence<n + 1>>)
    return count_fields<T, n + 1>();
  else
    return n;
}

/** References to the fields of a plain structure, for each number of fields that occurs. */
#define TALUS_FIELDS(n, ...)                                   \
  template <class T>                                           \
  auto fields_of(T& t, std::integral_constant<std::size_t, n>) \
  {                                                            \
    auto& [__VA_ARGS__] = t;                                   \
    return std::tie(__VA_ARGS__);                              \
  }
TALUS_FIELDS(1, a)
TALUS_FIELDS(2, a, b)
TALUS_FIELDS(3, a, b, c)
TALUS_FIELDS(4, a, b, c, d)
TALUS_FIELDS(5, a, b, c, d, e)
TALUS_FIELDS(7, a, b, c, d, e, f, g)
TALUS_FIELDS(11, a, b, c, d, e, f, g, h, i, j, k)
TALUS_FIELDS(12, a, b, c, d, e, f, g, h, i, j, k, l)
#undef TALUS_FIELDS
template <class T>
auto fields_of(T& t)
{
  return fields_of(
      t, std::integral_constant<std::size_t, count_fields<std::remove_const_t<T>>()>{});
}

/** Structures as one array for each field, so that loops vectorise. Floats are kept as bits, so
 * that no other float that a loop writes can alias one. */
template <class T, int kLanes, class Fields = decltype(fields_of(std::declval<T&>()))>
class SideBySide;
template <class T, int kLanes, class... Field>
class SideBySide<T, kLanes, std::tuple<Field&...>>
{
  using All = std::index_sequence_for<Field...>;

 public:
  T load(int l) const { return load(l, All{}); }
  void store(int l, const T& t) { store(l, t, All{}); }
  void fill(const T& t)
  {
    for (int l = 0; l < kLanes; l++) store(l, t);
  }

 private:
  template <std::size_t... i>
  T load(int l, std::index_sequence<i...>) const
  {
    T t{};
    const auto fields = fields_of(t);
    (get(std::get<i>(arrays_)[static_cast<std::size_t>(l)], std::get<i>(fields)), ...);
    return t;
  }
  template <std::size_t... i>
  void store(int l, const T& t, std::index_sequence<i...>)
  {
    const auto fields = fields_of(t);
    (put(std::get<i>(fields), std::get<i>(arrays_)[static_cast<std::size_t>(l)]), ...);
  }
  template <class F>
  static void get(F from, F& to)
  {
    to = from;
  }
  static void get(std::uint32_t from, float& to) { to = kernels::float_of_bits(from); }
  template <class F>
  static void put(F from, F& to)
  {
    to = from;
  }
  static void put(float from, std::uint32_t& to) { to = kernels::bits_of(from); }
  /** A plain array that is not cleared, as one in a tuple would be. */
  template <class F>
  struct Array : std::array<std::conditional_t<std::is_same_v<F, float>, std::uint32_t, F>, kLanes>
  {
    Array() {}
  };
  std::tuple<Array<Field>...> arrays_;
};

}  // namespace talus
