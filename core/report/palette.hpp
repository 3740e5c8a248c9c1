// Colours that colour-blind people can tell apart, on white paper.
//
// States, tables, causes of death and curves have the colours of Okabe and Ito, "Color Universal
// Design" (2008); quantities have ramps whose lightness (CIE L*) falls all the way, so that they
// read in grey, too.
#pragma once

#include <cstddef>

namespace somas::report {

/// Colour channels in [0, 1].
struct Colour {
  double red = 0, green = 0, blue = 0, alpha = 1;
};

/// 0xRRGGBB.
[[nodiscard]] constexpr Colour rgb(unsigned code, double alpha = 1) {
  return {(code >> 16 & 255) / 255.0, (code >> 8 & 255) / 255.0, (code & 255) / 255.0, alpha};
}

inline constexpr Colour black{0.1, 0.1, 0.1, 1};
inline constexpr Colour white{1, 1, 1, 1};
inline constexpr Colour frame_grey = rgb(0x808080);

/// `share` of every channel.
[[nodiscard]] Colour darker(const Colour& colour, double share);
/// From `a` (0) to `b` (1).
[[nodiscard]] Colour between(const Colour& a, const Colour& b, double t);

/// Neither black (rims, letters) nor vermillion (the first table) is a state's. From the seventh
/// state on they return darker.
[[nodiscard]] Colour colour_of_state(std::size_t state);
[[nodiscard]] Colour colour_of_table(std::size_t table);
[[nodiscard]] Colour colour_of_cause(std::size_t cause);
/// Of the outline of an organism in company; black is the rim of dividing cells.
[[nodiscard]] Colour colour_of_organism(std::size_t organism);

/// Content of a grid: white at 0, at 1 a grey of lightness 84, so that cells stand out.
[[nodiscard]] Colour grey_ramp(double t);
/// Energy: the greener, the higher; from nearly white to dark green.
[[nodiscard]] Colour green_ramp(double t);
/// Concentration of one morphogen: from white over a hue (cyan, magenta, yellow; then grey) to
/// a dark shade of it.
[[nodiscard]] Colour morphogen_ramp(std::size_t kind, double t);
/// The first three morphogens at once, as inks on paper: cyan, magenta, yellow.
[[nodiscard]] Colour inks(double cyan, double magenta, double yellow);

}  // namespace somas::report
