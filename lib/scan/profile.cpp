#include "profile.h"

#include <gpsrecon/core/error.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gpsrecon::internal {
namespace {

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

std::size_t chords(double radius, double angle, double tolerance) {
  const double widest = 2 * std::acos(std::max(0.5, 1 - tolerance / radius));
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(angle / widest)));
}

/// Whether the direction from the centre points into the sector of the arc (at most half a circle).
bool Profile::Piece::arc_covers(const Vec2& direction) const {
  return turn * cross(start - center, direction) >= 0 && turn * cross(direction, end - center) >= 0;
}

Vec2 Profile::Piece::own_normal(const Vec2& at) const {
  if (turn != 0) return turn * (at - center) / radius;  // a left turn keeps the centre inside
  const Vec2 along = (end - start).normalized();
  return {along.y(), -along.x()};
}

Profile& Profile::append(Piece piece) {
  piece.start_normal = piece.own_normal(piece.start);
  piece.end_normal = piece.own_normal(piece.end);
  if (!pieces_.empty()) {
    const Vec2 before = pieces_.back().end_normal;
    join_end(piece.start_normal);
    piece.start_normal = (piece.start_normal + before).normalized();
  }
  pieces_.push_back(piece);
  return *this;
}

Profile& Profile::line_to(const Vec2& end) {
  Piece piece;
  piece.start = this->end();
  piece.end = end;
  return append(piece);
}

Profile& Profile::arc_to(const Vec2& end, const Vec2& center, double turn) {
  Piece piece;
  piece.start = this->end();
  piece.end = end;
  piece.turn = turn;
  piece.center = center;
  piece.radius = (piece.start - center).norm();
  if (std::abs((end - center).norm() - piece.radius) > 1e-9 * piece.radius)
    throw OptionError("the ends of an arc are not equally far from its centre");
  if (turn * cross(piece.start - center, end - center) < -1e-9 * piece.radius * piece.radius)
    throw OptionError("an arc is longer than half a circle");
  return append(piece);
}

Profile& Profile::arc_left_to(const Vec2& end, const Vec2& center) {
  return arc_to(end, center, 1);
}
Profile& Profile::arc_right_to(const Vec2& end, const Vec2& center) {
  return arc_to(end, center, -1);
}

void Profile::join_start(const Vec2& normal) {
  pieces_.front().start_normal = (pieces_.front().start_normal + normal).normalized();
}

void Profile::join_end(const Vec2& normal) {
  pieces_.back().end_normal = (pieces_.back().end_normal + normal).normalized();
}

ProfilePoint Profile::closest(const Vec2& p) const {
  ProfilePoint best{start_, start_normal(), std::numeric_limits<double>::infinity(), false};
  const auto consider = [&](const Vec2& q, const auto& normal_at) {
    const double squared_distance = (p - q).squaredNorm();
    if (squared_distance >= best.squared_distance) return;
    const Vec2 normal = normal_at();
    best = {q, normal, squared_distance, (p - q).dot(normal) > 0};
  };
  for (const Piece& piece : pieces_) {
    bool inner = false;  // the closest point is not an end of the piece
    Vec2 q;
    if (piece.turn == 0) {
      const Vec2 along = piece.end - piece.start;
      const double t = (p - piece.start).dot(along) / along.squaredNorm();
      inner = t > 0 && t < 1;
      if (inner) q = piece.start + t * along;
    } else {
      const Vec2 direction = p - piece.center;
      const double length = direction.norm();
      inner = length > 0 && piece.arc_covers(direction);
      if (inner) q = piece.center + direction * (piece.radius / length);
    }
    if (inner) {
      consider(q, [&] { return piece.own_normal(q); });
    } else {
      consider(piece.start, [&] { return piece.start_normal; });
      consider(piece.end, [&] { return piece.end_normal; });
    }
  }
  return best;
}

Eigen::AlignedBox2d Profile::box() const {
  Eigen::AlignedBox2d box(start_);
  for (const Piece& piece : pieces_) {
    box.extend(piece.end);
    if (piece.turn == 0) continue;
    for (const Vec2& direction : {Vec2(1, 0), Vec2(0, 1), Vec2(-1, 0), Vec2(0, -1)})
      if (piece.arc_covers(direction)) box.extend(piece.center + piece.radius * direction);
  }
  return box;
}

double Profile::support(const Vec2& direction) const {
  double support = start_.dot(direction);
  for (const Piece& piece : pieces_) {
    support = std::max(support, piece.end.dot(direction));
    if (piece.turn != 0 && piece.arc_covers(direction))
      support = std::max(support, piece.center.dot(direction) + piece.radius);
  }
  return support;
}

std::vector<Vec2> Profile::sample(double tolerance) const {
  std::vector<Vec2> points{start_};
  for (const Piece& piece : pieces_) {
    if (piece.turn != 0) {
      const Vec2 from = piece.start - piece.center, to = piece.end - piece.center;
      const double angle = std::atan2(std::abs(cross(from, to)), from.dot(to));
      const std::size_t segments = chords(piece.radius, angle, tolerance);
      for (std::size_t k = 1; k < segments; ++k) {
        const double turned = piece.turn * angle * static_cast<double>(k) / static_cast<double>(segments);
        points.push_back(piece.center + Eigen::Rotation2Dd(turned) * from);
      }
    }
    points.push_back(piece.end);
  }
  return points;
}

}  // namespace gpsrecon::internal
