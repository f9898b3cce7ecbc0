#pragma once
#include "kernels/math.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

namespace talus
{
/** Structures as one array for each field, so that loops vectorise. Floats are kept as bits, so
 * that no other float that a loop writes can alias one. */
template <class T, int kLanes, class Fields = decltype(T::fields())>
class SideBySide;
template <class T, int kLanes, class... Field>
class SideBySide<T, kLanes, std::tuple<Field T::*...>>
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
    (get(std::get<i>(arrays_)[static_cast<std::size_t>(l)], t.*std::get<i>(T::fields())), ...);
    return t;
  }
  template <std::size_t... i>
  void store(int l, const T& t, std::index_sequence<i...>)
  {
    (put(t.*std::get<i>(T::fields()), std::get<i>(arrays_)[static_cast<std::size_t>(l)]), ...);
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
