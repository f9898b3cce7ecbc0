#pragma once
#include <array>
#include <cstddef>
#include <tuple>
#include <utility>

namespace talus
{
/** Structures side by side, for vector code, an array each field. */
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
    ((t.*std::get<i>(T::fields()) = std::get<i>(arrays_)[static_cast<std::size_t>(l)]), ...);
    return t;
  }
  template <std::size_t... i>
  void store(int l, const T& t, std::index_sequence<i...>)
  {
    ((std::get<i>(arrays_)[static_cast<std::size_t>(l)] = t.*std::get<i>(T::fields())), ...);
  }
  /** As memory came: a tuple would clear a plain array each time. */
  template <class F>
  struct Array : std::array<F, kLanes>
  {
    Array() {}
  };
  std::tuple<Array<Field>...> arrays_;
};

}  // namespace talus
