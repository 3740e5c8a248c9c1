#include "core/experiment/sweep.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "core/experiment/keys.hpp"
#include "core/experiment/overlay.hpp"
#include "core/experiment/reader.hpp"
#include "core/experiment/validate.hpp"
#include "core/plugins/suggest.hpp"
#include "core/plugins/yaml_text.hpp"

namespace somas::experiment {
namespace {

/// Columns of index.csv and summary.csv, which a factor must not be called.
constexpr std::string_view taken_names[] = {
    "run",       "runs",        "condition", "replicate",       "seed",       "status",
    "directory", "generations", "best",      "best_generation", "final_best", "final_median",
    "set_aside", "reason",      "complete",  "failed"};

/// Keys that say what a file or a campaign is, not what is simulated.
constexpr std::string_view fixed_keys[] = {"somas",   "name",  "seed",      "extends",
                                           "plugins", "sweep", "replicates"};

template <class List>
bool is_one_of(const List& list, std::string_view text) {
  return std::find(std::begin(list), std::end(list), text) != std::end(list);
}

// ---- a value as text ---------------------------------------------------------------------------

std::string flow_text(const Node& node, bool nested);

std::string items_text(const Node& node) {
  std::string text;
  for (const Node& item : node.items) {
    if (!text.empty()) text += ", ";
    if (node.kind == Node::Kind::mapping) text += plugins::yaml_text(item.key) + ": ";
    text += flow_text(item, true);
  }
  return text;
}

/// YAML in one line that reads back to the same node.
std::string flow_text(const Node& node, bool nested = false) {
  switch (node.kind) {
    case Node::Kind::null:
      return "null";
    case Node::Kind::sequence:
      return "[" + items_text(node) + "]";
    case Node::Kind::mapping:
      return "{" + items_text(node) + "}";
    case Node::Kind::scalar:
      break;
  }
  // What was plain in a block may not be so within brackets.
  const bool ends_flow = nested && node.text.find_first_of(",[]{}") != std::string::npos;
  return node.quoted || ends_flow ? plugins::yaml_text(node.text) : node.text;
}

// ---- which values are the same -----------------------------------------------------------------

/// Equal for numbers that are equal, however they are written.
std::string canonical(const std::string& value) {
  double number = 0;
  const char* end = value.data() + value.size();
  const auto parsed = std::from_chars(value.data(), end, number);
  const bool is_number = parsed.ec == std::errc{} && parsed.ptr == end;
  return is_number ? "number " + plugins::format_number(number) : value;
}

std::string normalized(const std::string& key) {
  std::string path;
  for (const std::string& segment : path_segments(key)) path += segment + ".";
  return path;
}

// ---- reading -----------------------------------------------------------------------------------

class DesignReader {
 public:
  explicit DesignReader(Problems& problems) : problems_(problems) {}

  void read(const Node& sweep) {
    if (sweep.kind != Node::Kind::mapping) {
      problems_.add(
          sweep.position, "sweep",
          "expected a mapping of factors (KEY: [VALUE, ...]), found " + sweep.description());
      return;
    }
    for (const Node& factor : sweep.items) read_factor(factor, "sweep." + factor.key);
  }

  /// A factor of the command line: levels of a key, or some of the file's named ones.
  void read(const std::string& text) {
    const Position position{"--sweep " + text, 0, 0};
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw InputError(position, "expected KEY=VALUE,VALUE,...");
    Node factor = parse_value("[" + text.substr(equals + 1) + "]", position);
    factor.key = text.substr(0, equals);
    for (const Node& level : factor.items)
      if (level.kind == Node::Kind::null && text.find("null", equals) == std::string::npos)
        throw InputError(position, "a level between two commas is empty");
    if (is_one_of(by_hand_, factor.key))
      throw InputError(position, factor.key + ": was swept before; give all its levels at once");
    by_hand_.push_back(factor.key);

    // In the place of the file's.
    const auto same = std::find_if(read_.begin(), read_.end(),
                                   [&](const Read& one) { return one.factor.name == factor.key; });
    if (same != read_.end() && same->named) return choose(factor, *same);
    const auto place = same - read_.begin();
    if (same != read_.end()) read_.erase(same);
    const std::size_t before = read_.size();
    read_factor(factor, factor.key);
    if (read_.size() > before) std::rotate(read_.begin() + place, read_.end() - 1, read_.end());
  }

  /// Replaced values that a factor would replace again, and factors that meet.
  void check_overlaps(const std::vector<std::string>& overrides) {
    for (const std::string& assignment : overrides)
      for (const Read& one : read_)
        for (const std::string& key : one.keys)
          if (normalized(assignment.substr(0, assignment.find('='))).starts_with(normalized(key)))
            problems_.add({"--set " + assignment, 0, 0}, key,
                          "the sweep sets it (" + one.position.text() + "); --sweep " + key +
                              "=VALUE replaces its levels, --single leaves the sweep out");
    for (std::size_t i = 0; i < read_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) check_pair(read_[j], read_[i]);
  }

  [[nodiscard]] std::vector<Factor> take() {
    std::vector<Factor> factors;
    for (Read& one : read_) factors.push_back(std::move(one.factor));
    return factors;
  }

 private:
  struct Read {
    Factor factor;
    Position position;
    std::vector<std::string> keys;  ///< that it sets
    bool named = false;             ///< its levels have names
  };

  void read_factor(const Node& node, const std::string& path) {
    Read one{.factor = {.name = node.key, .levels = {}}, .position = node.key_position, .keys = {}};
    const bool named = one.named = node.kind == Node::Kind::mapping;
    if (!named && node.kind != Node::Kind::sequence) {
      problems_.add(node.position, path,
                    "expected a list of levels, [VALUE, ...], or a mapping of named ones, found " +
                        node.description());
      return;
    }
    if (node.items.empty()) {
      problems_.add(node.position, path, "no levels; a factor has one at least");
      return;
    }
    if (named ? !is_factor_name(node, path) : !is_key(node.key, node.key_position, path)) return;
    for (const Node& level : node.items) named ? named_level(level, path, one) : value(level, one);
    refuse_duplicates(node, path, one.factor);
    read_.push_back(std::move(one));
  }

  /// The levels of a factor that have these names.
  void choose(const Node& names, Read& one) {
    std::vector<std::string> known;
    for (const Level& level : one.factor.levels) known.push_back(level.value);
    std::vector<Level> chosen;
    for (const Node& name : names.items) {
      const auto found = std::find(known.begin(), known.end(), name.text);
      if (found == known.end())
        problems_.add(name.position, one.factor.name,
                      "has no level '" + name.text + "'; have: " + plugins::join(known) +
                          plugins::did_you_mean(name.text, known));
      else
        chosen.push_back(one.factor.levels[static_cast<std::size_t>(found - known.begin())]);
    }
    if (names.items.empty())
      problems_.add(names.position, one.factor.name, "no levels; a factor has one at least");
    one.factor.levels = std::move(chosen);
    refuse_duplicates(names, one.factor.name, one.factor);
  }

  void value(const Node& level, Read& one) {
    const std::string text = flow_text(level);
    add_key(one, one.factor.name);
    one.factor.levels.push_back(
        {text, {{one.factor.name + "=" + text, level.position, one.position}}});
  }

  void named_level(const Node& level, const std::string& path, Read& one) {
    const std::string here = path + "." + level.key;
    if (level.kind != Node::Kind::mapping) {
      problems_.add(level.position, here,
                    "expected a mapping of the keys that the level '" + level.key +
                        "' sets, found " + level.description() + " (levels of one key: '" +
                        one.factor.name + "." + level.key + ": [VALUE, ...]')");
      return;
    }
    Level read{.value = level.key, .sets = {}};
    for (const Node& set : level.items) {
      if (!is_key(set.key, set.key_position, here)) continue;
      add_key(one, set.key);
      read.sets.push_back({set.key + "=" + flow_text(set), set.position, set.key_position});
    }
    one.factor.levels.push_back(std::move(read));
  }

  static void add_key(Read& one, const std::string& key) {
    if (!is_one_of(one.keys, key)) one.keys.push_back(key);
  }

  bool is_factor_name(const Node& node, const std::string& path) {
    if (!is_one_of(taken_names, node.key)) return true;
    problems_.add(node.key_position, path,
                  "a column of index.csv or summary.csv has this name; give the factor another");
    return false;
  }

  // Whether it is a key of an experiment file that may differ between conditions, as far as its
  // first part tells: the rest shows when a condition is loaded.
  bool is_key(const std::string& key, const Position& position, const std::string& path) {
    const std::vector<std::string> segments = path_segments(key);
    if (std::any_of(segments.begin(), segments.end(), [](const auto& s) { return s.empty(); })) {
      problems_.add(position, path, "'" + key + "': a part of the path is empty");
      return false;
    }
    if (is_one_of(fixed_keys, segments[0])) {
      problems_.add(position, path,
                    "'" + segments[0] + "' cannot be swept" +
                        (segments[0] == "seed" ? "; 'replicates: N' runs N seeds" : ""));
      return false;
    }
    std::vector<std::string> known = other_keys();
    for (const ParameterInfo& info : core_keys()) known.emplace_back(info.name);
    std::erase_if(known, [](const std::string& name) { return is_one_of(fixed_keys, name); });
    if (is_one_of(known, segments[0])) return true;
    problems_.add(position, path,
                  "no key of an experiment begins with '" + segments[0] + "'; allowed: " +
                      plugins::join(known) + plugins::did_you_mean(segments[0], known));
    return false;
  }

  void refuse_duplicates(const Node& node, const std::string& path, const Factor& factor) {
    if (node.kind != Node::Kind::sequence) return;
    for (std::size_t i = 0; i < factor.levels.size() && i < node.items.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (canonical(factor.levels[i].value) == canonical(factor.levels[j].value)) {
          const Position& first = node.items[j].position;
          problems_.add(node.items[i].position, path,
                        factor.levels[i].value + " is a level already" +
                            (first.line != 0 ? " (" + first.text() + ")" : ""));
          break;
        }
  }

  void check_pair(const Read& first, const Read& second) {
    for (const std::string& key : second.keys)
      for (const std::string& other : first.keys) {
        const std::string a = normalized(key), b = normalized(other);
        if (!a.starts_with(b) && !b.starts_with(a)) continue;
        problems_.add(second.position, "sweep." + second.factor.name,
                      "sets " + key + ", and the factor " + first.factor.name + " sets " + other +
                          " (" + first.position.text() + "); a key belongs to one factor");
        return;
      }
  }

  Problems& problems_;
  std::vector<Read> read_;
  std::vector<std::string> by_hand_;
};

/// What a campaign needs of the core's keys; what is wrong with the others shows later.
void read_core(const Node& root, const std::filesystem::path& file, Design& design,
               Problems& problems) {
  Node part;
  part.kind = Node::Kind::mapping;
  for (const char* key : {"name", "seed", "replicates"})
    if (const Node* node = root.find(key)) part.items.push_back(*node);
  const CoreValues values = core_values(Validator(problems).group(core_keys(), part, ""));
  design.name = root.find("name") != nullptr ? values.name : file.stem().string();
  design.seed = static_cast<std::uint64_t>(values.seed);
  design.replicates = static_cast<std::uint64_t>(values.replicates);
  const auto last = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (design.seed > last - design.replicates)
    problems.add(nearest(root, "seed").position, "seed",
                 "leaves no seeds for " + plugins::plural(design.replicates, "replicate"));
}

void check_size(const Design& design, const Position& position) {
  std::uint64_t runs = design.replicates;
  for (const Factor& factor : design.factors) {
    runs *= factor.levels.size();
    if (runs > most_runs)
      throw InputError(position, "the campaign has more than " + std::to_string(most_runs) +
                                     " runs; allowed: at most that many");
  }
}

}  // namespace

void check_sweep(const Node& root, Problems& problems) {
  DesignReader reader(problems);
  if (const Node* sweep = root.find("sweep")) reader.read(*sweep);
  reader.check_overlaps({});
}

std::uint64_t Design::conditions() const {
  std::uint64_t product = 1;
  for (const Factor& factor : factors) product *= factor.levels.size();
  return product;
}

std::optional<Design> read_design(const std::filesystem::path& file, const DesignOptions& options) {
  Design design;
  design.original_yaml = read_text(file);
  Node root = read_tree(file, design.original_yaml);
  for (const std::string& assignment : options.overrides)
    apply_override(root, set_by_hand(assignment));
  if (!options.always && options.sweeps.empty() && root.find("sweep") == nullptr &&
      root.find("replicates") == nullptr)
    return std::nullopt;

  Problems problems;
  read_core(root, file, design, problems);
  DesignReader reader(problems);
  const Node* sweep = root.find("sweep");
  if (sweep != nullptr) reader.read(*sweep);
  for (const std::string& text : options.sweeps) reader.read(text);
  reader.check_overlaps(options.overrides);
  problems.raise();
  design.factors = reader.take();
  check_size(design, sweep != nullptr ? sweep->key_position : Position{file.string(), 0, 0});
  return design;
}

}  // namespace somas::experiment
