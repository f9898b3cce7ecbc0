#include <talus/calibrate/information.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr int kMaxBlocks = 40;  // stretches of time that may share an error

constexpr double kMaxSlopeVariance = 0.01;  // of a plane's slopes: 6 degrees

using ByPlane = Eigen::Matrix<double, kParameters, 3>;
using Clusters = std::vector<Vector>;

/** rho' of the loss. */
double loss_weight(double square) { return 1 / (1 + square / (kLoss * kLoss)); }

/** A residual by its deviation, with its robust weight. */
struct Row
{
  double value = 0, weight = 0;
  Vector j = Vector::Zero();
  std::array<Vector, 2> by_slope{Vector::Zero(), Vector::Zero()};  //!< change of j with the slopes
  Eigen::Vector3d q;  //!< by the plane
  int block = 0;
};

class Gatherer
{
 public:
  Gatherer(const ScanSet& scans, const PoseTrack& track, const Vector& v, const Association& a)
      : scans_(scans), association_(a)
  {
    evaluate_geometry(scans, track, v, geometry_);
    start_s_ = track.first_s();
    // Blocks of a second or longer: errors of poses go on for some frames.
    block_s_ = std::max(1.0, (track.last_s() - track.first_s()) / kMaxBlocks);
    blocks_.assign(static_cast<std::size_t>(kMaxBlocks) + 2, Vector::Zero());
  }

  Information run()
  {
    for (const Patch& p : association_.patches) add(p);
    for (const Vector& g : blocks_) info_.gradient += g * g.transpose();
    info_.variance_factor = squares_ / std::max(1.0, weights_ - 3.0 * patches_);
    // Half of the square of a plane's error follows the residuals' real size.
    info_.feigned *= info_.variance_factor;
    return info_;
  }

 private:
  int block_of(double time_s) const
  {
    const double i = (time_s - start_s_) / block_s_;
    return static_cast<int>(std::clamp(i + 1, 0.0, kMaxBlocks + 1.0));
  }
  std::vector<Row> rows_of(const Patch& p) const;
  void add(const Patch& p);
  void add_gradients(const std::vector<Row>& rows, const ByPlane& elimination);

  const ScanSet& scans_;
  const Association& association_;
  Geometry geometry_;
  double start_s_ = 0, block_s_ = 1;
  Information info_;
  Clusters blocks_;
  double squares_ = 0, weights_ = 0;
  int patches_ = 0;
};

std::vector<Row> Gatherer::rows_of(const Patch& p) const
{
  std::vector<Row> rows;
  for (std::uint32_t i = p.first; i < p.first + p.count; ++i)
  {
    const Sample& s = association_.samples[i];
    const Eigen::Vector3d point = scans_.point(s.point);
    const Residual r = residual_of(geometry_, association_, s, p, point, p.plane);
    const auto moves =
        point_by_parameters(geometry_.mounting, geometry_.views[s.view], r.at_sensor_m);
    const double scale = -r.by_plane[0];
    Row row;
    row.value = r.distance_m / s.sigma_m;
    row.weight = loss_weight(row.value * row.value);
    row.j = r.by_parameters / s.sigma_m;
    for (int k = 0; k < 2; ++k)
      row.by_slope[static_cast<std::size_t>(k)] = -moves.row(k).transpose() * scale / s.sigma_m;
    row.q = r.by_plane / s.sigma_m;
    row.block = block_of(scans_.views()[s.view].time_s);
    rows.push_back(row);
  }
  if (!p.contact) return rows;
  const ContactResidual c = contact_residual(*p.contact, p.plane, association_.scatter);
  for (int k = 0; k < 3; ++k)
  {
    Row row;
    row.value = c.value[k];
    row.weight = loss_weight(row.value * row.value);
    row.q = c.by_plane.row(k).transpose();
    row.block = block_of(p.contact->time_s);
    rows.push_back(row);
  }
  return rows;
}

void Gatherer::add(const Patch& p)
{
  const auto rows = rows_of(p);
  Matrix A = Matrix::Zero();
  std::array<std::array<Matrix, 2>, 2> A_slopes;
  for (auto& row : A_slopes) row.fill(Matrix::Zero());
  ByPlane B = ByPlane::Zero();
  std::array<ByPlane, 2> B_slopes{ByPlane::Zero(), ByPlane::Zero()};
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (const Row& r : rows)
  {
    A += r.weight * r.j * r.j.transpose();
    B += r.weight * r.j * r.q.transpose();
    C += r.weight * r.q * r.q.transpose();
    for (std::size_t k = 0; k < 2; ++k)
    {
      B_slopes[k] += r.weight * r.by_slope[k] * r.q.transpose();
      for (std::size_t l = 0; l < 2; ++l)
        A_slopes[k][l] += r.weight * r.by_slope[k] * r.by_slope[l].transpose();
    }
  }
  const Eigen::Matrix3d C_inverse = C.inverse();
  const double slope_variance = std::max(C_inverse(1, 1), C_inverse(2, 2));
  if (!(slope_variance < kMaxSlopeVariance)) return;  // no information
  ++patches_;
  info_.normal += A - B * C_inverse * B.transpose();
  for (int k = 0; k < 2; ++k)
    for (int l = 0; l < 2; ++l)
    {
      const auto &Bk = B_slopes[static_cast<std::size_t>(k)],
                 &Bl = B_slopes[static_cast<std::size_t>(l)];
      const Matrix& Akl = A_slopes[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)];
      info_.feigned += C_inverse(k + 1, l + 1) * (Akl - Bk * C_inverse * Bl.transpose());
    }
  for (const Row& r : rows)
  {
    squares_ += r.weight * r.value * r.value;
    weights_ += r.weight;
  }
  add_gradients(rows, B * C_inverse);
}

/** Gradients by patch, by block of time, and by both (counted twice so far). */
void Gatherer::add_gradients(const std::vector<Row>& rows, const ByPlane& elimination)
{
  Clusters own(blocks_.size(), Vector::Zero());
  Vector sum = Vector::Zero();
  for (const Row& r : rows)
  {
    const Vector g = r.weight * r.value * (r.j - elimination * r.q);
    own[static_cast<std::size_t>(r.block)] += g;
    sum += g;
  }
  info_.gradient += sum * sum.transpose();
  for (std::size_t b = 0; b < own.size(); ++b)
  {
    info_.gradient -= own[b] * own[b].transpose();
    blocks_[b] += own[b];
  }
}
}  // namespace

Information gather_information(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const Association& a)
{
  return Gatherer(scans, track, v, a).run();
}

Matrix covariance_of(const Information& info, const Choice& chosen)
{
  std::vector<int> index;
  for (int i = 0; i < kParameters; ++i)
    if (chosen[static_cast<std::size_t>(i)]) index.push_back(i);
  Matrix covariance = Matrix::Zero();
  if (index.empty()) return covariance;
  const Eigen::MatrixXd S = info.normal(index, index), G = info.gradient(index, index);
  const Eigen::MatrixXd bread = Eigen::MatrixXd(S - info.feigned(index, index)).inverse();

  // The clusters are few: where they happen to agree too well, what independent points would give.
  const Eigen::MatrixXd L = S.llt().matrixL();
  const Eigen::MatrixXd L_inverse = L.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ratio(L_inverse * G * L_inverse.transpose());
  const Eigen::VectorXd least = ratio.eigenvalues().cwiseMax(info.variance_factor);
  const Eigen::MatrixXd LV = L * ratio.eigenvectors();
  const Eigen::MatrixXd meat = LV * least.asDiagonal() * LV.transpose();
  covariance(index, index) = bread * meat * bread.transpose();
  return covariance;
}

}  // namespace talus::calibrate
