#include "core/run/campaign.hpp"

#include <algorithm>
#include <cstdio>
#include <map>

#include "core/experiment/node.hpp"
#include "core/run/files.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;

constexpr const char* campaign_file = "campaign.json";
constexpr const char* campaign_format = "somas-campaign/1";
constexpr std::size_t longest_level = 40, longest_name = 200;

bool is_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// The end of a key that tells most: "mutation" of "evolution.mutation", "controller" of
/// "controller.plugin", "budgets.0" of "a.budgets.0".
std::string short_name(const std::string& factor) {
  std::vector<std::string> segments = experiment::path_segments(factor);
  if (segments.size() > 1 && segments.back() == "plugin") segments.pop_back();
  std::size_t first = segments.size() - 1;
  while (first > 0 && is_number(segments[first])) --first;
  std::string name = segments[first];
  for (std::size_t i = first + 1; i < segments.size(); ++i) name += "." + segments[i];
  return name;
}

/// Letters, digits and a few signs; every other piece becomes one '-'.
std::string safe(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '.' || c == '_' || c == '-';
    if (plain)
      result += c;
    else if (!result.empty() && result.back() != '-')
      result += '-';
  }
  while (result.ends_with('-')) result.pop_back();
  return result.substr(0, longest_level);
}

/// Each text once: those that are equal to an earlier one get -2, -3, ...
void make_unique(std::vector<std::string>& texts) {
  std::map<std::string, int> seen;
  for (std::string& text : texts)
    if (const int count = ++seen[text]; count > 1) text += "-" + std::to_string(count);
}

std::vector<std::string> factor_labels(const experiment::Design& design) {
  std::vector<std::string> labels;
  for (const experiment::Factor& factor : design.factors) labels.push_back(short_name(factor.name));
  std::map<std::string, int> count;
  for (const std::string& label : labels) ++count[label];
  for (std::size_t i = 0; i < labels.size(); ++i)
    labels[i] = safe(count[labels[i]] > 1 ? design.factors[i].name : labels[i]);
  make_unique(labels);
  return labels;
}

std::vector<std::string> level_labels(const experiment::Factor& factor) {
  std::vector<std::string> labels;
  for (const experiment::Level& level : factor.levels) {
    labels.push_back(safe(level.value));
    if (labels.back().empty()) labels.back() = "level";
  }
  make_unique(labels);
  return labels;
}

/// File names have at most 255 bytes.
std::string bounded(const std::string& name) {
  if (name.size() <= longest_name) return name;
  return name.substr(0, longest_name - 9) + "-" + hash_of_text(name).substr(0, 8);
}

std::string replicate_name(std::uint64_t replicate) {
  char text[40];
  std::snprintf(text, sizeof text, "replicate-%03llu", static_cast<unsigned long long>(replicate));
  return text;
}

std::vector<std::string> texts_in(const JsonView& list) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < list.size(); ++i) texts.emplace_back(list.item(i).text());
  return texts;
}

}  // namespace

std::vector<Condition> conditions_of(const experiment::Design& design) {
  if (design.factors.empty()) return {{.name = "all", .levels = {}, .sets = {}}};
  const std::vector<std::string> names = factor_labels(design);
  std::vector<Condition> conditions(1);
  for (std::size_t f = 0; f < design.factors.size(); ++f) {
    const experiment::Factor& factor = design.factors[f];
    const std::vector<std::string> labels = level_labels(factor);
    std::vector<Condition> longer;
    for (const Condition& condition : conditions)
      for (std::size_t l = 0; l < factor.levels.size(); ++l) {
        Condition& next = longer.emplace_back(condition);
        next.name.append(next.name.empty() ? "" : "+").append(names[f]).append("=");
        next.name += labels[l];
        next.levels.push_back(factor.levels[l].value);
        next.sets.insert(next.sets.end(), factor.levels[l].sets.begin(),
                         factor.levels[l].sets.end());
      }
    conditions = std::move(longer);
  }
  for (Condition& condition : conditions) condition.name = bounded(condition.name);
  return conditions;
}

std::vector<PlannedRun> Campaign::runs() const {
  std::vector<PlannedRun> runs;
  for (std::size_t condition = 0; condition < conditions.size(); ++condition)
    for (std::uint64_t replicate = 1; replicate <= replicates; ++replicate)
      runs.push_back(
          {.condition = condition,
           .replicate = replicate,
           .seed = seed + replicate - 1,
           .directory = fs::path(conditions[condition].name) / replicate_name(replicate)});
  return runs;
}

std::vector<std::string> Campaign::command_of(const PlannedRun& run, std::size_t genomes) const {
  std::vector<std::string> words = {"somas-host", "run", file.string(), "--single"};
  const auto add = [&](const char* option, const std::string& value) {
    words.emplace_back(option);
    words.push_back(value);
  };
  for (const std::string& assignment : overrides) add("--set", assignment);
  for (const experiment::Override& set : conditions[run.condition].sets) add("--set", set.text);
  add("--seed", std::to_string(run.seed));
  if (generations) add("--generations", std::to_string(*generations));
  for (std::size_t i = 0; i < genomes; ++i)
    add("--genome", (directory / "genomes" / ("given-" + std::to_string(i) + ".json")).string());
  for (const fs::path& path : plugin_path) add("--plugin-path", path.string());
  add("--out", (directory / run.directory).string());
  return words;
}

fs::path condition_file(const fs::path& campaign, const Condition& condition) {
  return campaign / "conditions" / (condition.name + ".yaml");
}

Json campaign_to_json(const Campaign& campaign) {
  Json json;
  json["format"] = campaign_format;
  json["experiment"] = campaign.experiment;
  json["file"] = campaign.file.string();
  json["directory"] = campaign.directory.string();
  json["seed"] = campaign.seed;
  json["replicates"] = campaign.replicates;
  json["factors"] = campaign.factors;
  json["conditions"] = Json::array();
  for (const Condition& condition : campaign.conditions) {
    Json one;
    one["name"] = condition.name;
    one["levels"] = condition.levels;
    one["set"] = Json::array();
    for (const experiment::Override& set : condition.sets) one["set"].push_back(set.text);
    json["conditions"].push_back(std::move(one));
  }
  json["set"] = campaign.overrides;
  json["sweep"] = campaign.sweeps;
  json["plugin_path"] = Json::array();
  for (const fs::path& path : campaign.plugin_path) json["plugin_path"].push_back(path.string());
  json["command_line"] = campaign.command_line;
  if (campaign.generations) json["generations"] = *campaign.generations;
  return json;
}

Campaign read_campaign(const fs::path& directory) {
  const std::string origin = (directory / campaign_file).string();
  const Json json = parse_json(read_file(origin), origin);
  const JsonView view(json, origin);
  if (view.member("format").text() != campaign_format)
    throw UsageError(origin + ": this host reads the format " + campaign_format);
  Campaign campaign;
  campaign.experiment = view.member("experiment").text();
  campaign.file = view.member("file").text();
  campaign.original_yaml = read_file(directory / "experiment.yaml");
  campaign.directory = view.member("directory").text();
  campaign.seed = view.member("seed").natural();
  campaign.replicates = view.member("replicates").natural();
  campaign.factors = texts_in(view.member("factors"));
  const JsonView& conditions = view.member("conditions");
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    const JsonView& one = conditions.item(i);
    Condition& condition = campaign.conditions.emplace_back();
    condition.name = one.member("name").text();
    condition.levels = texts_in(one.member("levels"));
    if (condition.levels.size() != campaign.factors.size())
      one.member("levels").fail("a level per factor");
    for (std::string& text : texts_in(one.member("set")))
      condition.sets.push_back({std::move(text), {}, {}});
  }
  campaign.overrides = texts_in(view.member("set"));
  campaign.sweeps = texts_in(view.member("sweep"));
  for (const std::string& path : texts_in(view.member("plugin_path")))
    campaign.plugin_path.emplace_back(path);
  campaign.command_line = texts_in(view.member("command_line"));
  if (view.has("generations")) campaign.generations = view.member("generations").natural();
  return campaign;
}

bool holds_campaign(const fs::path& directory) {
  std::error_code error;
  return fs::exists(directory / campaign_file, error);
}

}  // namespace somas::run
