#include "oblique.h"

#include <opencv2/imgproc.hpp>
#include <picture_relief.h>
#include <picture_style.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace talus::pictures
{
namespace
{
constexpr int kOversampling = 2, kFractionBits = 4;
constexpr double kNearest_m = 0.5;
const cv::Vec3b kPaper(255, 255, 255), kWay(io::bgr(io::palette::kPath.rgb)), kRobot(250, 250, 250);
const cv::Vec3b kFoot(io::bgr(io::palette::kStands.rgb)),
    kHigh(205, 190, 184);  //!< of what stands, BGR
constexpr double kHigh_m = 2.5;

/** A polygon of one colour; what is farther is painted first. */
struct Face
{
  double distance_m;
  std::array<cv::Point, 4> corners;
  cv::Vec3b colour;
};

/** The faces of all that is seen. */
class Scene
{
 public:
  Scene(const io::LayerStack& map, const Camera& camera);

  void add_ground();
  void add_objects();
  void add_way(const std::vector<cv::Point2d>& way);
  void add_robot(const RobotBox& robot);
  cv::Mat painted();

 private:
  bool is_known(int x, int y) const
  {
    return x >= 0 && y >= 0 && x < map_.cells_x && y < map_.cells_y &&
           terrain_.measured(row(y), x) != 0;
  }
  int row(int y) const { return map_.cells_y - 1 - y; }
  float ground(int x, int y) const { return terrain_.ground_m(row(y), x); }
  /** How high it stands above the ground; 0: nothing does that blocks. */
  double height_m(int x, int y) const;
  double corner_height_m(int x, int y) const;
  cv::Vec3d place(double x, double y, double z_m) const
  {
    return {map_.min_x_m + x * map_.resolution_m, map_.min_y_m + y * map_.resolution_m, z_m};
  }
  double ground_at_m(const cv::Point2d& p_m) const;
  void add(const std::array<cv::Vec3d, 4>& corners_m, const cv::Vec3b& colour, double nearer_m = 0);
  void add_side(int x, int y, const cv::Point& to, double from_m, double to_m, float light);
  void add_box(const RobotBox& robot, double z_m);

  const io::LayerStack& map_;
  Camera camera_;
  io::Terrain terrain_;
  cv::Mat1f top_m_;
  std::vector<Face> faces_;
};

Scene::Scene(const io::LayerStack& map, const Camera& camera)
    : map_(map), camera_(camera), terrain_(io::terrain_of(map)), top_m_(terrain_.score.size())
{
  camera_.focal_px *= kOversampling;
  camera_.size *= kOversampling;
  const auto& top = *map.find(layer_name(Layer::Elevation));
  for (int y = 0; y < map.cells_y; ++y)
    for (int x = 0; x < map.cells_x; ++x)
      top_m_(row(y), x) = top[static_cast<std::size_t>(y) * map.cells_x + x];
}

void Scene::add(const std::array<cv::Vec3d, 4>& corners_m, const cv::Vec3b& colour, double nearer_m)
{
  Face face{0, {}, colour};
  bool is_seen = false;
  for (std::size_t i = 0; i < 4; ++i)
  {
    const cv::Vec3d p = camera_.pixel(corners_m[i]);
    if (p[2] < kNearest_m || std::abs(p[0]) > 1e5 || std::abs(p[1]) > 1e5) return;
    is_seen = is_seen || cv::Rect2d({}, cv::Size2d(camera_.size)).contains({p[0], p[1]});
    face.corners[i] = {cvRound(p[0] * (1 << kFractionBits)), cvRound(p[1] * (1 << kFractionBits))};
    face.distance_m += p[2] / 4;
  }
  if (!is_seen) return;
  face.distance_m -= nearer_m;
  faces_.push_back(face);
}

double Scene::height_m(int x, int y) const
{
  constexpr float kPassable = 0.5F;
  if (!is_known(x, y) || terrain_.obstacle(row(y), x) == 0) return 0;
  if (terrain_.score(row(y), x) > kPassable) return 0;
  return top_m_(row(y), x) - ground(x, y);
}

/** Where up to four cells meet. */
double Scene::corner_height_m(int x, int y) const
{
  double sum = 0;
  int count = 0;
  for (const int dx : {-1, 0})
    for (const int dy : {-1, 0})
      if (is_known(x + dx, y + dy))
      {
        sum += ground(x + dx, y + dy);
        ++count;
      }
  return sum / count;
}

void Scene::add_ground()
{
  const cv::Mat3b colours = io::paint_terrain(terrain_, map_.resolution_m);
  for (int y = 0; y < map_.cells_y; ++y)
    for (int x = 0; x < map_.cells_x; ++x)
    {
      if (!is_known(x, y) || height_m(x, y) > 0) continue;
      add({place(x, y, corner_height_m(x, y)), place(x + 1, y, corner_height_m(x + 1, y)),
           place(x + 1, y + 1, corner_height_m(x + 1, y + 1)),
           place(x, y + 1, corner_height_m(x, y + 1))},
          colours(row(y), x));
    }
}

/** Colour of what stands at a height above the ground. */
cv::Vec3b colour_at(double height_m, float light)
{
  const auto part = static_cast<float>(std::clamp(height_m / kHigh_m, 0.0, 1.0));
  return io::mixed(kFoot, kHigh, part) * light;
}

/** The side of a cell that faces `to`, in pieces so that it is lighter the higher it is. */
void Scene::add_side(int x, int y, const cv::Point& to, double from_m, double to_m, float light)
{
  constexpr double kPiece_m = 0.4;
  const cv::Point2d middle(x + 0.5 + 0.5 * to.x, y + 0.5 + 0.5 * to.y),
      along(-0.5 * to.y, 0.5 * to.x);
  const cv::Point2d a = middle - along, b = middle + along;
  const double z = ground(x, y);
  for (double low = from_m; low < to_m; low += kPiece_m)
  {
    const double high = std::min(to_m, low + kPiece_m);
    add({place(a.x, a.y, z + low), place(b.x, b.y, z + low), place(b.x, b.y, z + high),
         place(a.x, a.y, z + high)},
        colour_at((low + high) / 2, light));
  }
}

void Scene::add_objects()
{
  for (int y = 0; y < map_.cells_y; ++y)
    for (int x = 0; x < map_.cells_x; ++x)
    {
      const double h = height_m(x, y);
      if (h <= 0) continue;
      for (const cv::Point& to : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}})
      {
        const cv::Vec3d towards = camera_.eye_m - place(x + 0.5, y + 0.5, 0);
        const double beside = height_m(x + to.x, y + to.y);
        if (towards[0] * to.x + towards[1] * to.y > 0 && beside < h)
          add_side(x, y, to, beside, h, to.x != 0 ? 0.72F : 0.9F);
      }
      const double z = ground(x, y) + h;
      add({place(x, y, z), place(x + 1, y, z), place(x + 1, y + 1, z), place(x, y + 1, z)},
          colour_at(h, 1.05F));
    }
}

double Scene::ground_at_m(const cv::Point2d& p_m) const
{
  const auto x = static_cast<int>(std::floor((p_m.x - map_.min_x_m) / map_.resolution_m));
  const auto y = static_cast<int>(std::floor((p_m.y - map_.min_y_m) / map_.resolution_m));
  return is_known(x, y) ? ground(x, y) : std::numeric_limits<double>::quiet_NaN();
}

void Scene::add_way(const std::vector<cv::Point2d>& way)
{
  constexpr double kWidth_m = 0.5, kLift_m = 0.03, kPiece_m = 0.3, kNearer_m = 0.4;
  for (std::size_t i = 1; i < way.size(); ++i)
  {
    const cv::Point2d all = way[i] - way[i - 1];
    const double length = cv::norm(all);
    const cv::Point2d side = cv::Point2d(-all.y, all.x) * (kWidth_m / 2 / length);
    const int pieces = std::max(1, static_cast<int>(length / kPiece_m));
    for (int k = 0; k < pieces; ++k)
    {
      const cv::Point2d a = way[i - 1] + all * (static_cast<double>(k) / pieces);
      const cv::Point2d b = way[i - 1] + all * (static_cast<double>(k + 1) / pieces);
      const double za = ground_at_m(a) + kLift_m, zb = ground_at_m(b) + kLift_m;
      if (std::isnan(za) || std::isnan(zb)) continue;
      const cv::Point2d corners[]{a - side, b - side, b + side, a + side};
      add({cv::Vec3d(corners[0].x, corners[0].y, za), cv::Vec3d(corners[1].x, corners[1].y, zb),
           cv::Vec3d(corners[2].x, corners[2].y, zb), cv::Vec3d(corners[3].x, corners[3].y, za)},
          kWay, kNearer_m);
    }
  }
}

void Scene::add_box(const RobotBox& r, double z_m)
{
  constexpr double kClearance_m = 0.25, kNearer_m = 1;
  const cv::Point2d ahead(std::cos(r.yaw_rad), std::sin(r.yaw_rad)), left(-ahead.y, ahead.x);
  const auto at = [&](double along, double across, double up)
  {
    const cv::Point2d p =
        r.at_m + ahead * (along * r.length_m / 2) + left * (across * r.width_m / 2);
    return cv::Vec3d(p.x, p.y, z_m + up);
  };
  const double low = kClearance_m, high = r.height_m;
  for (const cv::Point& to : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}})
  {
    const cv::Point2d outwards = ahead * to.x + left * to.y;
    const cv::Point2d towards(camera_.eye_m[0] - r.at_m.x, camera_.eye_m[1] - r.at_m.y);
    if (outwards.dot(towards) <= 0) continue;
    const int ax = to.x - to.y, ay = to.y + to.x, bx = to.x + to.y, by = to.y - to.x;
    add({at(ax, ay, low), at(bx, by, low), at(bx, by, high), at(ax, ay, high)},
        kRobot * (to.x != 0 ? 0.62F : 0.78F), kNearer_m);
  }
  add({at(-1, -1, high), at(1, -1, high), at(1, 1, high), at(-1, 1, high)}, kRobot,
      kNearer_m + 0.1);
  add({at(0.7, 0, high), at(-0.6, 0.6, high), at(-0.3, 0, high), at(-0.6, -0.6, high)}, kWay,
      kNearer_m + 0.2);
}

void Scene::add_robot(const RobotBox& robot)
{
  const double z_m = ground_at_m(robot.at_m);
  if (!std::isnan(z_m)) add_box(robot, z_m);
}

cv::Mat Scene::painted()
{
  std::stable_sort(
      faces_.begin(), faces_.end(),
      [](const Face& a, const Face& b) { return a.distance_m > b.distance_m; });
  cv::Mat image(camera_.size, CV_8UC3, cv::Scalar(kPaper)), small;
  for (const Face& f : faces_)
    cv::fillConvexPoly(image, f.corners.data(), 4, cv::Scalar(f.colour), cv::LINE_8, kFractionBits);
  cv::resize(image, small, {}, 1.0 / kOversampling, 1.0 / kOversampling, cv::INTER_AREA);
  return small;
}
}  // namespace

cv::Vec3d Camera::pixel(const cv::Vec3d& p_m) const
{
  const cv::Vec3d ahead = cv::normalize(target_m - eye_m);
  const cv::Vec3d right = cv::normalize(ahead.cross(cv::Vec3d(0, 0, 1)));
  const cv::Vec3d down = ahead.cross(right), p = p_m - eye_m;
  const double depth = p.dot(ahead);
  return {
      size.width / 2.0 + focal_px * p.dot(right) / depth,
      size.height / 2.0 + focal_px * p.dot(down) / depth, depth};
}

cv::Mat draw_oblique(
    const io::LayerStack& map, const Camera& camera, const std::vector<cv::Point2d>& way,
    const RobotBox& robot)
{
  Scene scene(map, camera);
  scene.add_ground();
  scene.add_objects();
  scene.add_way(way);
  scene.add_robot(robot);
  return scene.painted();
}

}  // namespace talus::pictures
