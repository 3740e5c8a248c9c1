#include "core/report/palette.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "somas/sdk/math.hpp"

namespace somas::report {
namespace {

constexpr std::array<Colour, 6> state_colours = {rgb(0xE69F00), rgb(0x0072B2), rgb(0x009E73),
                                                 rgb(0xCC79A7), rgb(0x56B4E9), rgb(0xF0E442)};
constexpr std::array<Colour, 3> table_colours = {rgb(0xD55E00), rgb(0x000000), rgb(0x7F3F98)};
constexpr std::array<Colour, 7> cause_colours = {rgb(0x999999), rgb(0xCC79A7), rgb(0x000000),
                                                 rgb(0xD55E00), rgb(0x56B4E9), rgb(0x009E73),
                                                 rgb(0xF0E442)};

constexpr std::array<Colour, 5> organism_colours = {rgb(0x00504A), rgb(0xC0268B), rgb(0x7A7A7A),
                                                    rgb(0x7A3B00), rgb(0x4B3FA0)};

/// White, a hue in the middle, a dark shade of it.
struct Hue {
  Colour middle, end;
};
constexpr std::array<Hue, 4> morphogen_hues = {{{rgb(0x1FA8C9), rgb(0x0B4A63)},
                                                {rgb(0xD6449F), rgb(0x7A0F5B)},
                                                {rgb(0xD9A900), rgb(0x6B5200)},
                                                {rgb(0x8A8A8A), rgb(0x3A3A3A)}}};

}  // namespace

Colour darker(const Colour& c, double share) {
  return {c.red * share, c.green * share, c.blue * share, 1};
}

Colour between(const Colour& a, const Colour& b, double t) {
  const auto mix = [t](double from, double to) { return from + (to - from) * t; };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue), mix(a.alpha, b.alpha)};
}

Colour colour_of_state(std::size_t state) {
  Colour colour = state_colours[state % state_colours.size()];
  for (std::size_t round = state / state_colours.size(); round > 0; --round)
    colour = darker(colour, 0.6);
  return colour;
}

Colour colour_of_table(std::size_t table) { return table_colours[table % table_colours.size()]; }

Colour colour_of_cause(std::size_t cause) { return cause_colours[cause % cause_colours.size()]; }

Colour colour_of_organism(std::size_t organism) {
  return organism_colours[organism % organism_colours.size()];
}

Colour grey_ramp(double t) {
  const double f = (100.0 - 16.0 * std::clamp(t, 0.0, 1.0) + 16) / 116;
  const double linear = f * f * f;
  const double grey = 1.055 * math::exp(math::log(linear) / 2.4) - 0.055;
  return {grey, grey, grey, 1};
}

Colour green_ramp(double t) {
  t = std::clamp(t, 0.0, 1.0);
  constexpr Colour low = rgb(0xF4FBF1), middle = rgb(0x74C476), high = rgb(0x005F26);
  return t < 0.5 ? between(low, middle, 2 * t) : between(middle, high, 2 * t - 1);
}

Colour morphogen_ramp(std::size_t kind, double t) {
  t = std::clamp(t, 0.0, 1.0);
  const Hue& hue = morphogen_hues[std::min(kind, morphogen_hues.size() - 1)];
  return t < 0.5 ? between(white, hue.middle, 2 * t) : between(hue.middle, hue.end, 2 * t - 1);
}

Colour inks(double cyan, double magenta, double yellow) {
  return {1 - std::clamp(cyan, 0.0, 1.0), 1 - std::clamp(magenta, 0.0, 1.0),
          1 - std::clamp(yellow, 0.0, 1.0), 1};
}

}  // namespace somas::report
