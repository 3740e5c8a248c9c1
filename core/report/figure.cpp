#include "core/report/figure.hpp"

#include <cmath>

#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "core/run/json.hpp"

namespace somas::report {
namespace {

constexpr double margin = 3;
constexpr double caption_line = 1.35 * caption_font;

std::uint64_t seed_of_run(const std::filesystem::path& run) {
  const std::filesystem::path file = run / "manifest.json";
  const run::Json manifest = run::parse_json(run::read_file(file), file.string());
  return run::JsonView(manifest, file.string()).member("seed").natural();
}

}  // namespace

PictureFormat picture_format(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (extension == ".svg") return PictureFormat::svg;
  if (extension == ".pdf") return PictureFormat::pdf;
  if (extension == ".png") return PictureFormat::png;
  throw run::UsageError(file.string() + ": the name of a picture ends in .svg, .pdf or .png");
}

Subject subject_of(const std::filesystem::path& run, const run::ReplayReport& replayed,
                   const std::vector<std::string>& overrides) {
  const run::Champion& champion = replayed.recorded;
  return {.experiment = champion.experiment,
          .run = name_of_directory(run),
          .seed = seed_of_run(run),
          .generation = champion.generation,
          .population = champion.population,
          .individual = champion.individual.id,
          .origin = std::string(evolution::name_of(champion.individual.origin)),
          .world_seed = champion.seed,
          .survival = replayed.replayed.outcome.survival,
          .censored = replayed.replayed.outcome.censored,
          .changes = overrides};
}

std::string caption_of(const Subject& s) {
  std::string text = s.experiment + ", run " + s.run + " (seed " + std::to_string(s.seed) +
                     "), generation " + std::to_string(s.generation);
  if (s.population != 0) text += ", population " + std::to_string(s.population);
  text += ": champion " + std::to_string(s.individual) + " (" + s.origin + "), world seed " +
          run::hex64(s.world_seed) + "; survival " + grouped(s.survival) + " steps";
  if (s.censored) text += " (alive at the end)";
  for (std::size_t i = 0; i < s.changes.size(); ++i)
    text += (i == 0 ? "; what if " : ", ") + s.changes[i];
  return text + ".";
}

std::string draw(const Frame& frame, const FigureSize& size) {
  const double width = size.width(), room = width - 2 * margin;
  const Canvas& ruler = measuring_canvas();
  const Legend legend(frame.legend, label_font);
  const std::string text = frame.title + " " + frame.caption;
  const std::vector<std::string> lines = ruler.wrapped(caption_font, room, text);
  const double legend_height = legend.height(ruler, room);
  const double height =
      std::ceil(2 * margin + frame.body + (legend_height > 0 ? legend_height + 2 : 0) +
                static_cast<double>(lines.size()) * caption_line + 2);

  Canvas canvas(size.format, width, height, size.format == PictureFormat::png ? size.scale() : 1);
  canvas.title(text);
  frame.paint(canvas, {margin, margin, room, frame.body});
  double y = margin + frame.body + 2;
  if (legend_height > 0) y += legend.paint(canvas, margin, y, room) + 2;
  for (const std::string& line : lines) {
    canvas.colour(black);
    canvas.label(margin, y + caption_font, caption_font, line);
    y += caption_line;
  }
  return canvas.finish();
}

const Canvas& measuring_canvas() {
  static const Canvas canvas(PictureFormat::png, 1, 1);
  return canvas;
}

std::string name_of_directory(const std::filesystem::path& directory) {
  const std::filesystem::path path = run::target_of(directory / ".").lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

std::string title_of_run(const std::filesystem::path& run) {
  return name_of_directory(run) + " (seed " + std::to_string(seed_of_run(run)) + ")";
}

std::string grouped(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

}  // namespace somas::report
