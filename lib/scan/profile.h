#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace gpsrecon::internal {

/// A point of the plane; of profiles that are turned about an axis (ρ, z): ρ >= 0 is the distance from the axis, z the
/// height along it.
using Vec2 = Eigen::Vector2d;

/// The point of a profile that is closest to another point p.
struct ProfilePoint {
  Vec2 point;
  Vec2 normal;              ///< unit, outward; at a corner the mean of both sides
  double squared_distance;  ///< |p - point|²
  bool outside;             ///< p lies on the outer side; false on the profile itself
};

/// The outline of a turned or extruded surface: a chain of straight segments and circular arcs in the plane, traversed
/// with the outside on the right (a closed outline runs counter-clockwise). Which side a point lies on is told by the
/// normal at the closest point; at corners by the mean of the two normals that meet there, which is right for every
/// corner short of a cusp.
class Profile {
 public:
  explicit Profile(const Vec2& start) : start_(start) {}

  Profile& line_to(const Vec2& end);
  /// The arc around `center` from the last point, turning left (counter-clockwise) or right, by at most half a circle.
  /// Throws OptionError if the two ends are not equally far from the centre to 1e-9 or the arc is longer.
  Profile& arc_left_to(const Vec2& end, const Vec2& center);
  Profile& arc_right_to(const Vec2& end, const Vec2& center);

  /// What continues the surface at the ends of the chain: the outward normal there.
  void join_start(const Vec2& normal);
  void join_end(const Vec2& normal);

  const Vec2& start() const { return start_; }
  const Vec2& end() const { return pieces_.empty() ? start_ : pieces_.back().end; }
  const Vec2& start_normal() const { return pieces_.front().start_normal; }
  const Vec2& end_normal() const { return pieces_.back().end_normal; }

  /// Precondition: at least one piece. O(pieces).
  ProfilePoint closest(const Vec2& p) const;

  bool is_closed() const { return start_ == end(); }

  /// The smallest and largest corner of the box around the chain.
  Eigen::AlignedBox2d box() const;
  /// The largest value of q · direction over the points q of the chain; the direction has length 1.
  double support(const Vec2& direction) const;

  /// Points of the chain from its start to its end, ends of pieces included, so that no point of the chain is farther
  /// than `tolerance` > 0 from the polygon through them.
  std::vector<Vec2> sample(double tolerance) const;

 private:
  struct Piece {
    Vec2 start = Vec2::Zero(), end = Vec2::Zero();
    Vec2 start_normal = Vec2::Zero(), end_normal = Vec2::Zero();  ///< means with the neighbours, once joined
    double turn = 0;  ///< 0 straight, +1 arc to the left, -1 arc to the right
    Vec2 center = Vec2::Zero();
    double radius = 0;

    bool arc_covers(const Vec2& direction) const;
    Vec2 own_normal(const Vec2& at) const;
  };
  Profile& arc_to(const Vec2& end, const Vec2& center, double turn);
  Profile& append(Piece piece);

  Vec2 start_;
  std::vector<Piece> pieces_;
};

/// Number of equal chords that replace an arc of `angle` radians so that none is farther than `tolerance` from it (and
/// none spans more than a third of a circle).
std::size_t chords(double radius, double angle, double tolerance);

}  // namespace gpsrecon::internal
