#pragma once
#include "pipeline.h"

// How layers leave a pipeline and come back.

namespace talus
{
template <class Executor>
std::array<bool, kLayerCount> Pipeline<Executor>::set_outputs(int slot, const OutputPointers& host)
{
  use(slot);
  std::array<bool, kLayerCount> delivered{};
  executor_.forget_outputs();
  const auto n = static_cast<std::size_t>(cells());
  for (std::size_t l = 0; l < host.size(); l++)
  {
    now_->outputs[l] = host[l] ? executor_.map_output(host[l], n) : OutputMemory{false, nullptr};
    delivered[l] = now_->outputs[l].reachable;
    now_->wanted[l] = delivered[l] ? host[l] : nullptr;
  }
  constexpr auto surfaces = static_cast<std::size_t>(Layer::Slope);
  executor_.allocate(now_->delivered, copied_surfaces() ? surfaces * n : 0, 0.0f);
  executor_.allocate(now_->traversability, n, kernels::kNan);
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

/** Whether a layer is wanted, and not yet where it is wanted when it is computed. */
template <class Executor>
bool Pipeline<Executor>::is_copied(Layer layer) const
{
  const auto l = static_cast<std::size_t>(layer);
  return now_->wanted[l] && !now_->outputs[l].direct;
}

/** How many of the layers [first, last] are. */
template <class Executor>
int Pipeline<Executor>::copied(Layer first, Layer last) const
{
  int n = 0;
  for (int l = static_cast<int>(first); l <= static_cast<int>(last); l++)
    n += is_copied(static_cast<Layer>(l));
  return n;
}

/** Their rows [first_row, end_row). */
template <class Executor>
void Pipeline<Executor>::deliver(Layer first, Layer last, int first_row, int end_row)
{
  for (int l = static_cast<int>(first); l <= static_cast<int>(last); l++)
    deliver(static_cast<Layer>(l), first_row, end_row);
}

/** The rows of a layer, if it is copied. */
template <class Executor>
void Pipeline<Executor>::deliver(Layer layer, int first_row, int end_row)
{
  if (!is_copied(layer)) return;
  const float* from = layer < Layer::Slope ? surface(layer) : feature(layer);
  const auto first = static_cast<std::size_t>(first_row) * static_cast<std::size_t>(side());
  const auto end = static_cast<std::size_t>(end_row) * static_cast<std::size_t>(side());
  executor_.copy(now_->wanted[static_cast<std::size_t>(layer)] + first, from + first, end - first);
}

/** What traversability is made of, if the last frame did not leave it: judges once more, with the
 * same result. */
template <class Executor>
void Pipeline<Executor>::complete_parts()
{
  if (now_->parts_known) return;
  allocate_parts();
  judge_rows<true>(0, side(), false);
  now_->parts_known = true;
}

template <class Executor>
void Pipeline<Executor>::read_layer(Layer layer, float* out)
{
  use(shown_);
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
  use(shown_);
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
  executor_.download(extent_.data(), n, to + n);
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
  use(shown_);
  const auto n = static_cast<std::size_t>(cells());
  const std::uint8_t* from = bytes.cells.data();
  for (auto* b : {&ground_, &ground_var_, &elevation_, &elevation_var_})
  {
    executor_.upload(reinterpret_cast<const float*>(from), n, b->data());
    from += n * sizeof(float);
  }
  for (auto* b : {&state_, &passed_}) executor_.upload(from, n, b->data()), from += n;
  executor_.upload(reinterpret_cast<const std::int8_t*>(from), n, misses_.data());
  executor_.upload(from + n, n, extent_.data());
  allocate_parts();
  now_->parts_known = true;
  for (std::size_t i = 0; i < kFeatureLayers; i++)
    executor_.upload(
        bytes.features.data() + i * n, n,
        feature(static_cast<Layer>(static_cast<std::size_t>(Layer::Slope) + i)));
  executor_.upload(&window, 1, context_.data());
  for (const Layer l : {Layer::Elevation, Layer::GroundElevation, Layer::Variance, Layer::State})
    if (surface(l)) export_surface(l, surface(l));
  deliver_surfaces(0, side());
  deliver_features(0, side());
  executor_.synchronize();
}

}  // namespace talus
