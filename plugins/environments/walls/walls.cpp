#include "plugins/environments/walls/walls.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "somas/sdk/math.hpp"

namespace somas::environments {

namespace {

constexpr std::size_t corners_of_a_disc = 32;  // of its outline

std::string path(std::size_t i, const char* key) {
  return "obstacles[" + std::to_string(i) + "]." + key;
}

/// Shortest decimal that reads back as x.
std::string text(double x) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr;
  return {digits.data(), end};
}

/// A key is given if, and only if, the kind has it.
void check_keys(std::size_t i, const Walls::Entry& e) {
  const bool disc = e.kind == "disc", gap = e.kind == "gap_wall", box = !disc && !gap;
  struct Key {
    const char* name;
    const std::optional<double>& value;
    bool wanted;
  };
  const Key keys[] = {{"x", e.x, true},
                      {"y", e.y, !gap},
                      {"radius", e.radius, disc},
                      {"half_width", e.half_width, box},
                      {"half_height", e.half_height, box || gap},
                      {"thickness", e.thickness, gap},
                      {"gap_y", e.gap_y, gap},
                      {"gap_width", e.gap_width, gap}};
  for (const Key& key : keys) {
    const std::string what = "kind '" + e.kind + "' ";
    if (key.wanted && !key.value)
      throw ParameterError(path(i, key.name), what + "needs '" + key.name + "'");
    if (!key.wanted && key.value)
      throw ParameterError(path(i, key.name), what + "has no '" + key.name + "'");
    if (key.value && !std::isfinite(*key.value))
      throw ParameterError(path(i, key.name), "must be finite");
  }
}

Obstacle rectangle(double x, double y, double half_width, double half_height) {
  return {Obstacle::Shape::box, x, y, half_width, half_height};
}

/// A gap_wall is two boxes, one on either side of the gap.
void add_gap_wall(std::size_t i, const Walls::Entry& e, std::vector<Obstacle>& obstacles) {
  const double lower = *e.gap_y - 0.5 * *e.gap_width, upper = *e.gap_y + 0.5 * *e.gap_width;
  const double end = *e.half_height;
  if (!(lower > -end && upper < end))
    throw ParameterError(path(i, "gap_width"), "the gap, from " + text(lower) + " to " +
                                                   text(upper) + ", must lie within the wall, " +
                                                   text(-end) + " to " + text(end));
  const double half = 0.5 * *e.thickness;
  obstacles.push_back(rectangle(*e.x, 0.5 * (lower - end), half, 0.5 * (lower + end)));
  obstacles.push_back(rectangle(*e.x, 0.5 * (upper + end), half, 0.5 * (end - upper)));
}

void add(std::size_t i, const Walls::Entry& e, std::vector<Obstacle>& obstacles) {
  check_keys(i, e);
  if (e.kind == "gap_wall") return add_gap_wall(i, e, obstacles);
  if (e.kind == "disc") {
    obstacles.push_back({Obstacle::Shape::disc, *e.x, *e.y, *e.radius, *e.radius});
    return;
  }
  obstacles.push_back(rectangle(*e.x, *e.y, *e.half_width, *e.half_height));
  if (e.kind == "enclosure") obstacles.back().shape = Obstacle::Shape::enclosure;
}

/// How deep a cell is in an obstacle, and the unit vector that leads out.
struct Contact {
  double depth;  ///< 0 or less: no contact
  double nx, ny;
};

/// The way out along (x, y), whose square of length is > 0.
Contact along(double x, double y, double square, double reach) {
  const double distance = std::sqrt(square);
  return {reach - distance, x / distance, y / distance};
}

Contact with_disc(double x, double y, double reach) {
  const double square = x * x + y * y;
  // At the very centre every way out is as short: take the one along x.
  return square > 0 ? along(x, y, square, reach) : Contact{reach, 1, 0};
}

Contact with_box(const Obstacle& box, double x, double y, double radius) {
  // Outside: away from the nearest point of the rectangle, so a corner pushes at a slant.
  const double away_x = x - std::clamp(x, -box.half_width, box.half_width);
  const double away_y = y - std::clamp(y, -box.half_height, box.half_height);
  const double square = away_x * away_x + away_y * away_y;
  if (square > 0) return along(away_x, away_y, square, radius);
  // The centre is inside: out by the nearest face; ties go to x before y, right before left, upper
  // before lower.
  const double to_side = box.half_width - std::abs(x), to_end = box.half_height - std::abs(y);
  if (to_side <= to_end) return {radius + to_side, x < 0 ? -1.0 : 1.0, 0};
  return {radius + to_end, 0, y < 0 ? -1.0 : 1.0};
}

/// Calls visit(Contact) for each contact of a cell: none or one with a disc or a box, up to one a
/// face in an enclosure.
template <class Visit>
void each_contact(const Obstacle& o, double x, double y, double radius, Visit&& visit) {
  const double dx = x - o.x, dy = y - o.y;
  const auto touch = [&](const Contact& contact) {
    if (contact.depth > 0) visit(contact);
  };
  if (o.shape == Obstacle::Shape::disc) return touch(with_disc(dx, dy, o.half_width + radius));
  if (o.shape == Obstacle::Shape::box) return touch(with_box(o, dx, dy, radius));
  // Each face of an enclosure pushes for itself, also a cell that is beyond it.
  touch({dx + radius - o.half_width, -1, 0});
  touch({-dx + radius - o.half_width, 1, 0});
  touch({dy + radius - o.half_height, 0, -1});
  touch({-dy + radius - o.half_height, 0, 1});
}

// Pictures shade what a closed outline bounds. An enclosure is solid outside itself, so it is a
// line that comes back to where it began.
bool is_closed(const Obstacle& o) { return o.shape != Obstacle::Shape::enclosure; }

std::vector<Point> outline_of(const Obstacle& o) {
  const double w = o.half_width, h = o.half_height;
  if (o.shape == Obstacle::Shape::enclosure)
    return {{o.x - w, o.y - h},
            {o.x + w, o.y - h},
            {o.x + w, o.y + h},
            {o.x - w, o.y + h},
            {o.x - w, o.y - h}};
  if (o.shape != Obstacle::Shape::disc)
    return {{o.x - w, o.y - h}, {o.x + w, o.y - h}, {o.x + w, o.y + h}, {o.x - w, o.y + h}};
  std::vector<Point> points;
  for (std::size_t i = 0; i < corners_of_a_disc; ++i) {
    const math::SinCos angle =
        math::sincos(math::two_pi * static_cast<double>(i) / corners_of_a_disc);
    points.push_back({o.x + w * angle.cos, o.y + w * angle.sin});
  }
  return points;
}

const char* name_of(Obstacle::Shape shape) {
  if (shape == Obstacle::Shape::disc) return "disc";
  return shape == Obstacle::Shape::box ? "box" : "enclosure";
}

}  // namespace

Walls::Walls(const Parameters& parameters)
    : stiffness_(parameters.stiffness),
      damping_(parameters.damping),
      lightest_mass_(parameters.lightest_mass) {
  for (std::size_t i = 0; i < parameters.obstacles.size(); ++i)
    add(i, parameters.obstacles[i], obstacles_);
}

void Walls::declare(Declare& declare) {
  const double limit = stable_contact_time_step(stiffness_, damping_, lightest_mass_);
  const double step = declare.world().time_step;
  if (!(step <= limit))
    throw ParameterError("stiffness", "contacts of cells of mass " + text(lightest_mass_) +
                                          " are stable up to a substep of " + text(limit) +
                                          ", but it is " + text(step) +
                                          "; lower 'stiffness' or 'damping', or shorten "
                                          "world.mechanics.time_step");
  for (const Obstacle& obstacle : obstacles_)
    declare.outline(name_of(obstacle.shape), outline_of(obstacle), is_closed(obstacle));
  declare.acts_in(Phase::forces);
}

void Walls::act(Phase, World& world) const {
  const Cells& cells = world.cells();
  const std::span<double> force_x = world.force_x(), force_y = world.force_y();
  for (std::uint32_t i = 0; i < cells.count; ++i) {
    for (const Obstacle& obstacle : obstacles_) {
      each_contact(obstacle, cells.x[i], cells.y[i], cells.radius[i], [&](const Contact& c) {
        const double leaving = cells.vx[i] * c.nx + cells.vy[i] * c.ny;
        const double push = stiffness_ * c.depth - damping_ * leaving;
        force_x[i] += push * c.nx;
        force_y[i] += push * c.ny;
      });
    }
  }
}

double stable_contact_time_step(double stiffness, double damping, double mass) {
  // The root in the form that loses no digits where the damper dominates.
  return 2 * mass / (damping + std::sqrt(damping * damping + 2 * stiffness * mass));
}

}  // namespace somas::environments
