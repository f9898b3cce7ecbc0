#pragma once
#include "pipeline.h"

// How layers leave a pipeline and come back.

namespace talus
{
template <class Executor>
std::array<bool, kLayerCount> Pipeline<Executor>::set_outputs(const OutputPointers& host)
{
  std::array<bool, kLayerCount> delivered{};
  executor_.forget_outputs();
  const auto n = static_cast<std::size_t>(cells());
  for (std::size_t l = 0; l < host.size(); l++)
  {
    outputs_[l] = host[l] ? executor_.map_output(host[l], n) : OutputMemory{false, nullptr};
    delivered[l] = outputs_[l].reachable;
    wanted_[l] = delivered[l] ? host[l] : nullptr;
  }
  const auto copied = [this](std::size_t l) { return wanted_[l] && !outputs_[l].direct; };
  constexpr auto surfaces = static_cast<std::size_t>(Layer::Slope);
  bool any = false;
  for (std::size_t l = 0; l < surfaces; l++) any = any || copied(l);
  executor_.allocate(delivered_, any ? surfaces * n : 0, 0.0f);
  if (parts_wanted()) allocate_parts();
  return delivered;
}

template <class Executor>
void Pipeline<Executor>::export_surface(Layer layer, float* to)
{
  const float* source = layer == Layer::Elevation         ? elevation_.data()
                        : layer == Layer::GroundElevation ? ground_.data()
                                                          : ground_var_.data();
  const std::uint8_t* state = layer == Layer::State ? state_.data() : nullptr;
  for_each_cell(kernels::ExportCell{config_.data(), context_.data(), source, state, to});
}

/** Elevation, ground, variance and state, as far as they are wanted and not there yet. */
template <class Executor>
void Pipeline<Executor>::deliver_surfaces()
{
  deliver(Layer::Elevation, Layer::State, [this](Layer l) { return surface(l); });
}

/** The layers of stages 8 and 9, likewise. */
template <class Executor>
void Pipeline<Executor>::deliver_features()
{
  deliver(Layer::Slope, Layer::Traversability, [this](Layer l) { return feature(l); });
}

template <class Executor>
template <class Find>
void Pipeline<Executor>::deliver(Layer first, Layer last, const Find& find)
{
  for (auto l = static_cast<std::size_t>(first); l <= static_cast<std::size_t>(last); l++)
    if (wanted_[l] && !outputs_[l].direct)
      executor_.copy(wanted_[l], find(static_cast<Layer>(l)), static_cast<std::size_t>(cells()));
}

/** What traversability is made of, if the last frame did not leave it: judges once more, with the
 * same result. */
template <class Executor>
void Pipeline<Executor>::complete_parts()
{
  if (parts_known_) return;
  allocate_parts();
  judge_with<true>();
  parts_known_ = true;
}

template <class Executor>
void Pipeline<Executor>::read_layer(Layer layer, float* out)
{
  const float* from = top_hit_.data();  // free between frames
  if (layer < Layer::Slope)
    export_surface(layer, top_hit_.data());
  else
  {
    if (layer != Layer::Traversability) complete_parts();
    from = feature(layer);
  }
  if (from != out) executor_.download(from, static_cast<std::size_t>(cells()), out);
}

template <class Executor>
MapBytes Pipeline<Executor>::read_all()
{
  const auto n = static_cast<std::size_t>(cells());
  MapBytes bytes;
  bytes.cells.resize(n * kBytesPerCell);
  std::uint8_t* to = bytes.cells.data();
  for (auto* b : {&ground_, &ground_var_, &elevation_, &elevation_var_})
  {
    executor_.download(b->data(), n, reinterpret_cast<float*>(to));
    to += n * sizeof(float);
  }
  for (auto* b : {&state_, &passed_}) executor_.download(b->data(), n, to), to += n;
  executor_.download(misses_.data(), n, reinterpret_cast<std::int8_t*>(to));
  complete_parts();
  bytes.features.resize(kFeatureLayers * n);
  for (std::size_t i = 0; i < kFeatureLayers; i++)
    executor_.download(
        feature(static_cast<Layer>(static_cast<std::size_t>(Layer::Slope) + i)), n,
        bytes.features.data() + i * n);
  return bytes;
}

template <class Executor>
void Pipeline<Executor>::write_all(const MapBytes& bytes, const kernels::FrameContext& window)
{
  const auto n = static_cast<std::size_t>(cells());
  const std::uint8_t* from = bytes.cells.data();
  for (auto* b : {&ground_, &ground_var_, &elevation_, &elevation_var_})
  {
    executor_.upload(reinterpret_cast<const float*>(from), n, b->data());
    from += n * sizeof(float);
  }
  for (auto* b : {&state_, &passed_}) executor_.upload(from, n, b->data()), from += n;
  executor_.upload(reinterpret_cast<const std::int8_t*>(from), n, misses_.data());
  allocate_parts();
  parts_known_ = true;
  for (std::size_t i = 0; i < kFeatureLayers; i++)
    executor_.upload(
        bytes.features.data() + i * n, n,
        feature(static_cast<Layer>(static_cast<std::size_t>(Layer::Slope) + i)));
  executor_.upload(&window, 1, context_.data());
  for (const Layer l : {Layer::Elevation, Layer::GroundElevation, Layer::Variance, Layer::State})
    if (surface(l)) export_surface(l, surface(l));
  deliver_surfaces();
  deliver_features();
  executor_.synchronize();
}

}  // namespace talus
