#include <talus/calibrate/information.h>

#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr double kMaxFeigned = 0.5;  // share of the information that may come from noise
constexpr double kShares = 0.5;  // of the largest share in a direction: has part in it
constexpr std::array<int, kParameters> kGivenUpFirst{kX, kY, kYaw, kTimeOffset, kZ, kRoll, kPitch};

double useful(int parameter)
{
  return parameter_infos()[static_cast<std::size_t>(parameter)].useful_sigma;
}

std::vector<int> chosen_of(const Choice& choice)
{
  std::vector<int> index;
  for (int i = 0; i < kParameters; ++i)
    if (choice[static_cast<std::size_t>(i)]) index.push_back(i);
  return index;
}

/** The parameter to give up of those that have part in a direction (in units of useful_sigma). */
int given_up(const std::vector<int>& index, const Eigen::VectorXd& direction)
{
  const double most = direction.cwiseAbs().maxCoeff();
  for (const int p : kGivenUpFirst)
    for (std::size_t i = 0; i < index.size(); ++i)
      if (index[i] == p && std::abs(direction[static_cast<Eigen::Index>(i)]) >= kShares * most)
        return p;
  return index.front();
}

/** The direction of which least is known, as a parameter to give up; -1 when enough is known. */
int weakest(const Information& info, const std::vector<int>& index)
{
  Eigen::VectorXd unit(index.size());
  for (std::size_t i = 0; i < index.size(); ++i)
    unit[static_cast<Eigen::Index>(i)] = useful(index[i]);
  const auto scaled = [&](const Matrix& M)
  { return Eigen::MatrixXd(unit.asDiagonal() * M(index, index) * unit.asDiagonal()); };
  const Eigen::MatrixXd S = scaled(info.normal) / info.variance_factor;
  const Eigen::MatrixXd N = scaled(info.feigned) / info.variance_factor;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> known(S - N);
  if (known.eigenvalues()[0] < 1) return given_up(index, known.eigenvectors().col(0));
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> feigned(N, S);
  const auto last = feigned.eigenvalues().size() - 1;
  if (feigned.eigenvalues()[last] > kMaxFeigned)
    return given_up(index, feigned.eigenvectors().col(last));
  return -1;
}

/** The parameter whose deviation is the worst, if it is not useful; -1 when all are. */
int least_useful(const Information& info, const Choice& choice, const std::vector<int>& index)
{
  const Matrix covariance = covariance_of(info, choice);
  int worst = -1;
  double most = 1;
  for (const int p : index)
  {
    const double sigma = std::sqrt(covariance(p, p)) / useful(p);
    if (sigma > most || !std::isfinite(sigma))
    {
      most = sigma;
      worst = p;
    }
  }
  return worst;
}
}  // namespace

Choice observable(const Information& info, const Choice& wanted)
{
  Choice choice = wanted;
  for (;;)
  {
    const auto index = chosen_of(choice);
    if (index.empty()) return choice;
    int out = weakest(info, index);
    if (out < 0) out = least_useful(info, choice, index);
    if (out < 0) return choice;
    choice[static_cast<std::size_t>(out)] = false;
  }
}

}  // namespace talus::calibrate
