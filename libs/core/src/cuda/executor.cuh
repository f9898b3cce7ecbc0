#pragma once
#include "backend.h"
#include "cuda/copy_large.h"
#include "cuda/loops.cuh"
#include "cuda/slot.h"

#include <array>

namespace talus
{
/** Runs the stages on a CUDA device. A frame is recorded once as a graph and then replayed with one
 * launch, on memory that does not move; it is recorded anew when memory grows or when other outputs
 * are wanted. Each slot has its own recording. The points of a frame travel while the frame before
 * is computed, its layers while the next one is. */
class CudaExecutor
{
 public:
  template <class T>
  using Buffer = DeviceBuffer<T>;
  using Atomics = kernels::DeviceAtomics;

  /** Throws std::runtime_error if there is no such device, or no code for it in this build. */
  explicit CudaExecutor(int number) : device_{number}
  {
    int devices = 0;
    const cudaError_t answer = cudaGetDeviceCount(&devices);
    static_cast<void>(cudaGetLastError());
    if (answer != cudaSuccess || devices == 0)
      throw std::runtime_error(
          std::string("no CUDA device answers") +
          (answer == cudaSuccess ? "" : std::string(": ") + cudaGetErrorString(answer)));
    TALUS_CUDA(cudaSetDevice(number));
    cudaDeviceProp device;
    TALUS_CUDA(cudaGetDeviceProperties(&device, number));
    name_ = std::string("cuda: ") + device.name;
    if (devices > 1)
      name_ += " (device " + std::to_string(number) + " of " + std::to_string(devices) + ")";
    cudaFuncAttributes code;
    if (cudaFuncGetAttributes(&code, loops::fetch) != cudaSuccess)
    {
      static_cast<void>(cudaGetLastError());
      throw std::runtime_error(
          std::string("built for other CUDA architectures than that of ") + device.name +
          ": set TALUS_CUDA_ARCHITECTURES");
    }
    // Code of an older architecture does not wait for its predecessor by itself.
    can_chain_ = device.major >= 9 && code.ptxVersion >= 90;
    marked_ = make_event();
    side_ = make_queue();
    use(0);
  }

  std::string name() const { return name_; }

  static constexpr bool kIsDevice = true;

  /** Selects the slot of the following calls, on the thread that calls it. */
  void use(int index)
  {
    TALUS_CUDA(cudaSetDevice(device_.number));  // CUDA keeps it for each thread
    now_ = static_cast<std::size_t>(index);
    if (!slot().queue.stream) slot() = CudaSlot::make();
  }

  // ---- memory: these calls wait until they are done ----
  /** Waits for the frames in flight, too. */
  template <class T>
  void allocate(Buffer<T>& buffer, std::size_t size, T value)
  {
    forget_recordings();
    buffer = {};
    buffer = Buffer<T>(size);
    fill(buffer, value);
    synchronize();
  }
  template <class T>
  using HostBuffer = PinnedBuffer<T>;
  /** Grows host memory that kernels reach to at least `size`; its contents are lost. */
  template <class T>
  void make_room(HostBuffer<T>& buffer, std::size_t size)
  {
    if (buffer.size() < size) buffer = PinnedBuffer<T>(size + size / 2);
  }
  template <class T>
  void transfer(const T* from, std::size_t size, T* to)
  {
    copy(to, from, size);
    synchronize();
  }
  void synchronize() { TALUS_CUDA(cudaStreamSynchronize(slot().queue.stream.get())); }
  /** Marks a point for wait_for_mark(). */
  void mark() { TALUS_CUDA(cudaEventRecord(marked_.get(), slot().queue.stream.get())); }
  void wait_for_mark() { TALUS_CUDA(cudaEventSynchronize(marked_.get())); }

  // ---- outputs ----
  OutputMemory map_output(float* host, std::size_t size)
  {
    auto& outputs = slot().outputs;
    outputs.emplace_back(host, size * sizeof(float));
    auto* mapped = static_cast<float*>(outputs.back().device());
    const bool fits = mapped && slot().direct_bytes + size * sizeof(float) <= kDirectBytes;
    if (fits) slot().direct_bytes += size * sizeof(float);
    return {mapped, fits};
  }
  void forget_outputs()
  {
    forget_recordings();
    slot().outputs.clear();
    slot().direct_bytes = 0;
  }

  // ---- the frame of the slot in use ----
  /** Graphs are recorded for as many points as there is room for. */
  int loop_size(int, std::size_t capacity) const { return static_cast<int>(capacity); }
  PointArrays point_arrays(std::size_t capacity)
  {
    CudaSlot& s = slot();
    if (capacity != s.capacity)
    {
      s.capacity = 0;  // until all memory is there
      s.staged = {};
      s.staged = PinnedBuffer<std::uint32_t>(kStagedPoints + 4 * capacity);
      std::memset(s.staged.data(), 0, s.staged.size() * sizeof(std::uint32_t));
      allocate(s.points, copies_points(capacity) ? 4 * capacity : 0, 0.0f);
      s.capacity = capacity;
    }
    auto* p = reinterpret_cast<float*>(s.staged.data() + kStagedPoints);
    return {p, p + capacity, p + 2 * capacity, p + 3 * capacity};
  }
  kernels::PointsIn stage(
      const Frame& frame, const kernels::FrameContext& context, std::size_t capacity)
  {
    slot().start = CudaSlot::Clock::now();
    const PointArrays to = point_arrays(capacity);
    std::memcpy(slot().staged.data(), &context, sizeof context);
    const float* const from[] = {frame.x_m, frame.y_m, frame.z_m, frame.time_s};
    float* const p = copies_points(capacity) ? slot().points.data() : to.x_m;
    const int arrays = frame.size == 0 ? 0 : context.has_times ? 4 : 3;
    std::array<CopyBlock, kMaxCopyBlocks> blocks;
    for (std::size_t a = 0; a < static_cast<std::size_t>(arrays); a++)
      blocks[a] = {to.x_m + a * capacity, from[a], frame.size * sizeof(float)};
    const auto send = [&](std::size_t a)
    {
      if (copies_points(capacity)) copy(p + a * capacity, to.x_m + a * capacity, frame.size);
    };
    copy_blocks(blocks.data(), arrays, std::ref(send));
    return {p, p + capacity, p + 2 * capacity, p + 3 * capacity};
  }
  /** Kernels read them in place: each value once, and only those of points that count. Recordings
   * know no frame, so that a channel that it does not have is there, and says nothing. */
  ChannelArrays stage_channels(const Frame& frame, std::size_t channels, std::size_t capacity)
  {
    CudaSlot& s = slot();
    if (s.channels.size() != channels * capacity)
    {
      s.channels = {};
      s.graphs = {};
      s.channels = PinnedBuffer<float>(channels * capacity);
    }
    ChannelArrays arrays{};
    for (std::size_t c = 0; c < channels; c++)
    {
      float* const to = s.channels.data() + c * capacity;
      arrays[c] = to;
      if (frame.channels[c])
        std::copy_n(frame.channels[c], frame.size, to);
      else
        std::fill_n(to, frame.size, kernels::kNan);
    }
    return arrays;
  }
  /** `starts_map`: the first frame has a recording of its own, which is seldom used again. */
  template <class Body>
  void start_frame(const Body& body, bool starts_map)
  {
    for (CudaSlot& other : slots_)
      if (other.in_flight) wait_until_computed(other);
    GraphExec& graph = slot().graphs[starts_map ? 1 : 0];
    if (!graph) graph = record(body);
    TALUS_CUDA(cudaGraphLaunch(graph.get(), slot().queue.stream.get()));
    slot().in_flight = true;
  }
  /** `then` follows the frame, and is waited for with it. */
  template <class Body, class Then>
  void finish_frame(const Body&, const Then& then)
  {
    then();
    slot().in_flight = false;
    synchronize();
  }
  void fetch(Buffer<kernels::FrameContext>& frame)
  {
    constexpr auto n = static_cast<int>(kContextWords);
    const std::uint32_t* const from = slot().staged.data();
    launch(
        loops::fetch, dim3(blocks(n, size_of(n))), dim3(size_of(n)), 0, n, from,
        reinterpret_cast<std::uint32_t*>(frame.data()));
    stage_end_++;
  }
  /** Where a frame leaves its counts for the host. */
  kernels::FrameCounts* reported() { return slot().counts.data(); }
  /** The kernels recorded since the last call belong to this stage. */
  void end_stage(Stage stage) { end_of_stage_[static_cast<std::size_t>(stage)] = stage_end_++; }
  std::array<double, kStageCount> stage_ms() const
  {
    std::array<double, kStageCount> ms{};
    const std::uint64_t* done = slot().stage_end_ns.data();
    for (std::size_t s = 0; s < ms.size(); s++)
      if (const int end_stage = end_of_stage_[s])
        ms[s] = static_cast<double>(done[end_stage] - done[end_stage - 1]) * 1e-6;
    return ms;
  }
  double total_ms() const
  {
    return std::chrono::duration<double, std::milli>(CudaSlot::Clock::now() - slot().start).count();
  }

  // ---- loops: they run in the order of the calls, within a frame as part of its graph ----
  template <class Rule>
  void for_each(const kernels::Map& m, int n)
  {
    launch(loops::over_range<Rule>, dim3(blocks(n, size_of(n))), dim3(size_of(n)), 0, n, m);
  }
  /** to[i] = f(i) for i in [0, n); `to` is host memory that kernels reach. */
  template <class F, class T>
  void for_each_to_host(int n, const F& f, T* to)
  {
    launch(
        loops::to_host<F, T>, dim3(blocks(n, loops::kHandedOver)), dim3(loops::kHandedOver), 0, n,
        f, to);
  }
  /** f(i, from[i]) for i in [0, n); `from` is host memory that kernels reach. */
  template <class F, class T>
  void for_each_from_host(int n, const F& f, const T* from)
  {
    launch(
        loops::from_host<F, T>, dim3(blocks(n, loops::kHandedOver)), dim3(loops::kHandedOver), 0, n,
        f, from);
  }
  /** `First` for the first elements, `Then` for the others of n, beside `Cells` for nx * ny. */
  template <class First, class Then, class Cells>
  void for_each_beside(const kernels::Map& m, int firsts, int n, int nx, int ny)
  {
    const int size = size_of(std::max(n, nx * ny));
    const dim3 cells = tiles(nx, ny, size / loops::kTileWidth);
    launch(
        loops::over_range_and_cells<First, Then, Cells>, dim3(blocks(n, size) + cells.x * cells.y),
        dim3(size), 0, firsts, n, nx, ny, in_line(cells), m);
  }
  /** For the points [0, n), and for up to `crowded` cells, though few are expected: UpdateCell. */
  template <class F>
  void for_each_and_group(const kernels::Map& m, int n, int crowded)
  {
    const int groups = crowded / kCellsPerGroup + 1;
    launch(
        loops::over_range_and_groups<F>, dim3(blocks(n + 32 * groups, size_of(n))),
        dim3(size_of(n)), 0, n, groups, m);
  }
  template <class F>
  void for_each_cell(const kernels::Map& m, const WindowRect& r, bool beside_last = false)
  {
    const int rows = r.size() < kManyThreads ? loops::kTileRows / 4 : loops::kTileRows;
    launch(
        loops::over_cells<F>, tiles(r.width, r.height, rows), dim3(loops::kTileWidth, rows), 0,
        r.first_x, r.first_x + r.width, r.first_y, r.first_y + r.height, m, beside_last);
  }
  /** f for square neighbourhoods. */
  template <class F>
  void for_each_window(const kernels::Map& m, int nx, int ny, int radius)
  {
    // As in for_each_judged_cell_of_rows(); the rows must fit into shared memory.
    int height = nx * ny < kManyThreads ? loops::kWindowThreads / 2 : loops::kTileWidth;
    const auto size = [&](int tile)
    {
      return static_cast<std::size_t>(loops::kTileWidth * (tile + 2 * radius)) *
             sizeof(typename F::Row);
    };
    while (size(height) > kSharedBytes) height--;
    launch(
        loops::over_windows<F>, tiles(nx, ny, height),
        dim3(loops::kTileWidth, loops::kWindowThreads), size(height), nx, ny, radius, height, m);
  }
  /** f for the neighbourhoods of cells, then g for the results of each cell and its neighbours, see
   * kernels::CompleteObstacles; for the rows [first, end) of ny. */
  template <class F, class G>
  void for_each_judged_cell_of_rows(
      const kernels::Map& m, int nx, int ny, int first, int end, int radius, bool beside_last)
  {
    // High tiles share more rows; with few cells low tiles spread over the device, one round each.
    constexpr int rows = loops::kWindowThreads;
    const int max_rows = std::min(loops::kJudgedRows, loops::kMaxRows - 2 * radius);
    const int height =
        (nx * ny < kManyThreads ? std::max(rows - 2 * radius, rows / 4) : max_rows) - 2;
    const auto size = static_cast<std::size_t>(loops::kTileWidth * (height + 2 + 2 * radius));
    const dim3 grid(blocks(nx, loops::kTileWidth - 2), blocks(end - first, height));
    launch(
        loops::over_windows_and_neighbours<F, G>, grid,
        dim3(loops::kTileWidth, loops::kWindowThreads), size * sizeof(typename F::Row), nx, ny,
        first, end, radius, height, m, beside_last);
  }
  /** kernels::SettleRays beside a range as in for_each_beside(), and H{m}(group) once. */
  template <class F, class First, class Then, class H>
  void for_each_direction_beside(const kernels::Map& m, int directions, int firsts, int n)
  {
    launch(
        loops::over_directions_and_range<F, First, Then, H>,
        dim3(blocks(directions, loops::kDirections) + 1 + blocks(n, loops::kThreads)),
        dim3(loops::kThreads), 0, directions, firsts, n, m);
  }
  /** Bit b of line l is F{m}(l, b), in the layout [word][line]. */
  template <class F>
  void pack_bits(const kernels::Map& m, int lines, int bits, std::uint32_t* words)
  {
    const int per_warp = lines * bits < kManyThreads ? 1 : kWordsPerWarp;
    launch(
        loops::over_bits<F>, dim3(blocks(32 * lines, loops::kThreads), blocks(bits, 32 * per_warp)),
        dim3(loops::kThreads), 0, lines, bits, m, words);
  }
  /** F{m}(x, y) says whether it marks a cell: bits of rows, then of columns, as [word][line]. */
  template <class F>
  void mark_cells(const kernels::Map& m, std::uint32_t* marks)
  {
    const int side = m.k.cells;
    launch(
        loops::over_marked_cells<F>, tiles(side, side, loops::kTileRows),
        dim3(loops::kTileWidth, loops::kTileRows), 0, side, m, marks);
  }
  /** f for the cells of the rows [first, end), see kernels::SearchAndFillCell. With few cells, each
   * side of each line has a thread. */
  template <class F>
  void for_each_cell_by_lines(const kernels::Map& m, int first, int end, bool beside_last)
  {
    const int n = m.k.cells;
    if (n * n < kManyThreads)
      launch(
          loops::over_cells_by_lines<F>, tiles(n, end - first, 1), dim3(32, 2 * F::kLines + 1), 0,
          n, first, m);
    else
      for_each_cell<F>(m, {0, first, n, end - first}, beside_last);
  }
  template <class T>
  void fill(Buffer<T>& buffer, T value)
  {
    const int n = static_cast<int>(buffer.size());
    launch(
        loops::fill_with<T>, dim3(blocks(n, size_of(n))), dim3(size_of(n)), 0, n, buffer.data(),
        value);
  }
  template <class T>
  void copy(T* to, const T* from, std::size_t size)
  {
    if (!size) return;
    if (beside_ && !forked_) follow(slot().queue, side_), forked_ = joins_ = true;
    TALUS_CUDA(
        cudaMemcpyAsync(to, from, size * sizeof(T), cudaMemcpyDefault, queue().stream.get()));
    queue().after_kernel = false;
  }

  /** Copies in `body` start after the work so far, and run beside what follows, up to join(). */
  template <class Body>
  void aside(const Body& body)
  {
    beside_ = true;
    forked_ = false;
    body();
    beside_ = false;
  }
  void join()
  {
    slot().marks_computed = joins_;
    if (!joins_) return;
    TALUS_CUDA(cudaEventRecordWithFlags(
        slot().computed.get(), slot().queue.stream.get(), cudaEventRecordExternal));
    follow(side_, slot().queue);
    joins_ = false;
  }
  /** body(first, end, beside_last) for all rows, in bands if `layers` are copied aside. The first
   * band is small, and each takes about as long as the copy of the one before, so that the bus
   * starts early and does not wait. There are fewer bands while the bus is busy with earlier
   * layers. Bands are independent: the kernels of all but the first may run beside the last one. */
  template <class Body>
  void in_bands(int rows, int layers, int before, const Body& body)
  {
    const auto bytes = static_cast<std::size_t>(layers) * static_cast<std::size_t>(rows) *
                       static_cast<std::size_t>(rows) * sizeof(float);
    int shares = 1;
    if (bytes >= kBandBytes)
      for (int share = 1; shares < kMinShares >> std::min(before, 2);)
        share *= layers, shares += share;
    for (int begin = 0, share = 1; begin < shares; begin += share, share *= layers)
      body(rows * begin / shares, rows * (begin + share) / shares, begin > 0);
  }

 private:
  static constexpr std::size_t kContextWords =
      sizeof(kernels::FrameContext) / sizeof(std::uint32_t);
  static constexpr std::size_t kStagedPoints =
      (kContextWords + 63) / 64 * 64;  //!< where the arrays begin
  /** Up to this size the accepting kernel reads points from host memory. The bus copies larger
   * frames, each array while the next one is staged. */
  static constexpr std::size_t kReadBytes = 512 * 1024;
  /** Layers up to this size are written to host memory by kernels; others are copied. */
  static constexpr std::size_t kDirectBytes = 1024 * 1024;
  static constexpr std::size_t kSharedBytes = 48 * 1024;  //!< every block can have them
  static constexpr int kCellsPerGroup = 4;  //!< 2 and 8 are slower
  static constexpr int kWordsPerWarp = 4;
  static constexpr int kManyThreads = 100000;  //!< they fill a device
  static constexpr std::size_t kBandBytes = 1024 * 1024;
  static constexpr int kMinShares = 4;

  CudaSlot& slot() { return slots_[now_]; }
  const CudaSlot& slot() const { return slots_[now_]; }
  WorkQueue& queue() { return beside_ ? side_ : slot().queue; }
  /** The kernels of the slot in use wait for those of another, not for its copies. */
  void wait_until_computed(CudaSlot& other)
  {
    if (!other.marks_computed)
      TALUS_CUDA(cudaEventRecord(other.computed.get(), other.queue.stream.get()));
    TALUS_CUDA(cudaStreamWaitEvent(slot().queue.stream.get(), other.computed.get(), 0));
  }
  void forget_recordings()
  {
    for (CudaSlot& s : slots_)
    {
      if (s.in_flight) TALUS_CUDA(cudaStreamSynchronize(s.queue.stream.get()));
      s.graphs = {};
    }
  }
  template <class Body>
  GraphExec record(const Body& body)
  {
    stage_end_ = 0;
    beside_ = forked_ = joins_ = slot().queue.after_kernel = false;
    recording_ = true;
    struct Off
    {
      bool& recording;
      ~Off() { recording = false; }
    } off{recording_};
    return instantiate(capture(slot().queue.stream, body));
  }

  /** The threads of a block. A few elements use small blocks, to spread over the device. */
  static int size_of(int n) { return n < kManyThreads ? loops::kThreads / 4 : loops::kThreads; }
  static unsigned blocks(int n, int size) { return static_cast<unsigned>((n + size - 1) / size); }
  static dim3 tiles(int nx, int ny, int rows)
  {
    return dim3(blocks(nx, loops::kTileWidth), blocks(ny, rows));
  }

  static loops::Tiles in_line(dim3 tiles)
  {
    return {static_cast<int>(tiles.x), 1.0f / static_cast<float>(tiles.x)};
  }

  /** Where the time of the current stage is noted. */
  std::uint64_t* time_note()
  {
    return recording_ ? slot().stage_end_ns.data() + stage_end_ : nullptr;
  }

  template <class... P, class... A>
  void launch(void (*kernel)(P...), dim3 grid, dim3 block, std::size_t shared, const A&... args)
  {
    if (!grid.x || !grid.y) return;
    WorkQueue& queue = slot().queue;
    cudaLaunchConfig_t config{};
    config.gridDim = grid;
    config.blockDim = block;
    config.dynamicSmemBytes = shared;
    config.stream = queue.stream.get();
    cudaLaunchAttribute chain{};
    chain.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    chain.val.programmaticStreamSerializationAllowed = 1;
    config.attrs = &chain;
    config.numAttrs = recording_ && can_chain_ && queue.after_kernel ? 1 : 0;
    TALUS_CUDA(cudaLaunchKernelEx(&config, kernel, args..., time_note()));
    queue.after_kernel = true;
  }

  /** Whether the bus copies the points as they are staged; else kernels read them in place. */
  static bool copies_points(std::size_t capacity)
  {
    return 3 * capacity * sizeof(float) > kReadBytes;
  }

  std::string name_;
  bool can_chain_ = false;
  bool recording_ = false, beside_ = false, forked_ = false, joins_ = false;
  int stage_end_ = 0;
  Event marked_;
  std::array<int, kStageCount> end_of_stage_{};
  WorkQueue side_;  //!< for copies, while a frame is recorded
  std::array<CudaSlot, kSlots> slots_;
  std::size_t now_ = 0;
  OwnDevice device_;  //!< last member: the others are freed on this device
};

}  // namespace talus
