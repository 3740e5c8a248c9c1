#include "core/run/champion.hpp"

#include <exception>
#include <new>
#include <utility>

#include "core/model/call_site.hpp"

namespace somas::run {
namespace {

constexpr std::string_view champion_format = "somas-champion/1";

// ---- writing -----------------------------------------------------------------------------------

using experiment::PluginUse;

Json chromosome_to_json(const Genes& genes, const Heritable& part, const PluginUse& owner) {
  Json json = Json::object();
  if (!owner.id.empty()) {
    json["plugin"] = owner.id;
    json["version"] = owner.version;
  }
  Json readable;
  JsonBuilder builder(readable);
  try {
    part.to_json(genes, builder);
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the plugin's
  } catch (const std::exception& error) {
    throw PluginError("plugin '" + owner.id + "': to_json: " + error.what());
  } catch (...) {
    throw PluginError("plugin '" + owner.id + "': to_json: an exception that is no std::exception");
  }
  json["genes"] = std::move(readable);
  json["bytes"] = hex_bytes(genes);
  return json;
}

Json replay_to_json(const Champion& champion) {
  const Outcome& outcome = champion.life.outcome;
  Json json;
  json["seed"] = hex64(champion.seed);
  json["survival"] = outcome.survival;
  json["censored"] = outcome.censored;
  json["score"] = champion.life.score;
  json["divisions"] = outcome.divisions;
  json["specializations"] = outcome.specializations;
  json["refused_divisions"] = outcome.refused_divisions;
  json["final_cells"] = outcome.final_cells;
  json["peak_cells"] = outcome.peak_cells;
  json["cell_steps"] = outcome.cell_steps;
  if (!champion.roster.empty()) json["biomass_share"] = outcome.biomass_share;
  return json;
}

Json steps_to_json(const LifeRecord& life) {
  Json census = Json::object();
  for (std::size_t state = 0; state < life.states.size(); ++state)
    census[life.states[state]] = life.census[state];
  Json hashes = Json::array();
  for (const std::uint64_t hash : life.hashes) hashes.push_back(hex64(hash));
  Json json;
  json["count"] = life.hashes.size();
  json["cells"] = std::move(census);
  json["world_hash"] = std::move(hashes);
  return json;
}

// ---- reading -----------------------------------------------------------------------------------

/// A genome as its file has it.
struct ReadGenome {
  model::Genome genome;
  bool matches_bytes = true;
  std::vector<std::string> other_versions;  ///< warnings
};

/// A part of a genome: in the file, in the organism, and who made it. `kind` names the part.
struct Part {
  const char* kind;
  const Heritable& heritable;
  const PluginUse& owner;
};

std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

// Genes of another plugin would fail on some detail of theirs: better say so at once.
void check_owner(const JsonView& json, const Part& part, ReadGenome& read) {
  if (part.owner.id.empty() || !json.has("plugin")) return;
  const std::string kind = part.kind;
  const std::string_view id = json.member("plugin").text();
  const std::string_view version = json.has("version") ? json.member("version").text() : "";
  const std::string made_for = "made for the " + kind + " " + in_quotes(id) +
                               (version.empty() ? "" : ", version " + std::string(version));
  if (id != part.owner.id)
    throw UsageError(json.place() + ": the genome was " + made_for + "; this experiment's " + kind +
                     " is " + in_quotes(part.owner.id));
  if (!version.empty() && version != part.owner.version)
    read.other_versions.push_back(json.place() + ": the genome was " + made_for +
                                  "; here it is version " + part.owner.version);
}

Genes genes_from_json(const JsonView& readable, const JsonView& chromosome, const Part& part) {
  // An old or handmade file may be of another plugin without saying so.
  const std::string doubt = chromosome.has("plugin") || part.owner.id.empty()
                                ? ""
                                : "; the file does not say which " + std::string(part.kind) +
                                      " it is for: is it " + in_quotes(part.owner.id) + "?";
  Genes genes;
  const std::string call = readable.place() + ": " + part.kind + ": from_json: ";
  try {
    const model::PluginCall here(part.kind, "from_json");
    part.heritable.from_json(readable, genes);
  } catch (const UsageError& error) {
    throw UsageError(error.what() + doubt);
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the plugin's
  } catch (const std::exception& error) {
    throw UsageError(call + error.what() + doubt);
  } catch (...) {
    throw UsageError(call + "an exception that is no std::exception" + doubt);
  }
  return genes;
}

Genes chromosome_from_json(const JsonView& json, const Part& part, ReadGenome& read) {
  check_owner(json, part, read);
  Genes genes = genes_from_json(json.member("genes"), json, part);
  if (!json.has("bytes")) return genes;
  const JsonView& bytes = json.member("bytes");
  const auto expected = parse_hex_bytes(bytes.text());
  if (!expected) bytes.fail("pairs of hexadecimal digits");
  if (*expected != genes) read.matches_bytes = false;
  return genes;
}

ReadGenome genome_from_json(const JsonView& json, const evolution::Heredity& heredity,
                            const GenomeOwners& owners) {
  ReadGenome read;
  read.genome.controller = chromosome_from_json(
      json.member("controller"), {"controller", heredity.controller(), owners.controller}, read);
  if (heredity.tree() != nullptr && json.has("specialization"))
    read.genome.tree =
        chromosome_from_json(json.member("specialization"),
                             {"specialization", *heredity.tree(), owners.specialization}, read);
  return read;
}

evolution::Individual individual_from_json(const JsonView& json) {
  evolution::Individual individual;
  individual.id = json.member("id").natural();
  const JsonView& parents = json.member("parents");
  for (std::size_t i = 0; i < parents.size(); ++i)
    individual.parents.push_back(parents.item(i).natural());
  const auto origin = evolution::operator_named(json.member("operator").text());
  if (!origin) json.member("operator").fail("the name of an operator");
  individual.origin = *origin;
  individual.fitness = json.member("fitness").number();
  const JsonView& trials = json.member("trials");
  for (std::size_t i = 0; i < trials.size(); ++i)
    individual.trials.push_back(trials.item(i).number());
  return individual;
}

std::uint32_t natural32(const JsonView& json) {
  const std::uint64_t value = json.natural();
  if (value > UINT32_MAX) json.fail("an integer below 2^32");
  return static_cast<std::uint32_t>(value);
}

Outcome outcome_from_json(const JsonView& json) {
  Outcome outcome;
  outcome.survival = json.member("survival").natural();
  outcome.censored = json.member("censored").boolean();
  outcome.divisions = json.member("divisions").natural();
  outcome.specializations = json.member("specializations").natural();
  outcome.refused_divisions = json.member("refused_divisions").natural();
  outcome.final_cells = natural32(json.member("final_cells"));
  outcome.peak_cells = natural32(json.member("peak_cells"));
  outcome.cell_steps = json.member("cell_steps").number();
  if (json.has("biomass_share")) outcome.biomass_share = json.member("biomass_share").number();
  return outcome;
}

void read_roster(const JsonView& json, const evolution::Heredity& heredity,
                 const GenomeOwners& owners, Champion& champion) {
  std::size_t champions = 0;
  for (std::size_t s = 0; s < json.size(); ++s) {
    const JsonView& item = json.item(s);
    RosterSeat& seat = champion.roster.emplace_back();
    seat.key = item.member("key").natural();
    for (std::size_t other = 0; other < s; ++other)
      if (champion.roster[other].key == seat.key)
        item.member("key").fail("a key that no other organism of the roster has");
    seat.x = item.member("x").number();
    seat.y = item.member("y").number();
    if (item.member("champion").boolean()) {
      champion.own_seat = s;
      ++champions;
      continue;
    }
    if (item.has("population")) seat.population = natural32(item.member("population"));
    if (item.has("id")) seat.id = item.member("id").natural();
    ReadGenome read = genome_from_json(item.member("genome"), heredity, owners);
    seat.genome = std::move(read.genome);
    champion.genes_match_bytes = champion.genes_match_bytes && read.matches_bytes;
  }
  if (json.size() < 2) json.fail("two organisms at least");
  if (champions != 1) json.fail("one champion");
}

// Fills hashes, and the census of the states that are already named.
void read_steps(const JsonView& json, LifeRecord& life) {
  const std::uint64_t count = json.member("count").natural();
  const JsonView& hashes = json.member("world_hash");
  if (hashes.size() != count) hashes.fail("a hash a step");
  for (std::size_t step = 0; step < count; ++step) life.hashes.push_back(hashes.item(step).key64());

  for (const std::string& state : life.states) {
    const JsonView& cells = json.member("cells").member(state);
    if (cells.size() != count) cells.fail("a number a step");
    std::vector<std::uint32_t>& counts = life.census.emplace_back();
    for (std::size_t step = 0; step < count; ++step) counts.push_back(natural32(cells.item(step)));
  }
}

}  // namespace

GenomeOwners owners_of(const experiment::Experiment& experiment) {
  return {experiment.controller, experiment.specialization};
}

std::string edited_warning(const std::string& origin) {
  return origin + ": the genome was edited: genes and bytes disagree; the genes count";
}

Json genome_to_json(const model::Genome& genome, const evolution::Heredity& heredity,
                    const GenomeOwners& owners) {
  Json json = Json::object();
  json["controller"] =
      chromosome_to_json(genome.controller, heredity.controller(), owners.controller);
  if (heredity.tree() != nullptr)
    json["specialization"] =
        chromosome_to_json(genome.tree, *heredity.tree(), owners.specialization);
  return json;
}

evaluation::Task task_of(const Champion& champion) {
  if (champion.roster.empty()) return single_task(champion.individual.genome, champion.seed);
  evaluation::Task task{{}, champion.seed};
  for (std::size_t s = 0; s < champion.roster.size(); ++s) {
    const RosterSeat& seat = champion.roster[s];
    const bool own = s == champion.own_seat;
    task.roster.push_back(
        {own ? &champion.individual.genome : &seat.genome, seat.key, seat.x, seat.y});
  }
  return task;
}

Json roster_to_json(std::span<const RosterSeat> roster, const evolution::Heredity& heredity,
                    const GenomeOwners& owners, std::optional<std::size_t> own) {
  Json list = Json::array();
  for (std::size_t s = 0; s < roster.size(); ++s) {
    const RosterSeat& seat = roster[s];
    Json& json = list.emplace_back();
    json["key"] = seat.key;
    json["x"] = seat.x;
    json["y"] = seat.y;
    if (own) json["champion"] = s == *own;
    if (s == own) continue;
    if (seat.population != 0) json["population"] = seat.population;
    if (seat.id) json["id"] = *seat.id;
    json["genome"] = genome_to_json(seat.genome, heredity, owners);
  }
  return list;
}

std::string to_text(const Champion& champion, const evolution::Heredity& heredity,
                    const GenomeOwners& owners) {
  const evolution::Individual& individual = champion.individual;
  Json json;
  json["format"] = champion_format;
  json["experiment"] = champion.experiment;
  json["generation"] = champion.generation;
  if (champion.population != 0) json["population"] = champion.population;
  json["id"] = individual.id;
  json["parents"] = individual.parents;
  json["operator"] = evolution::name_of(individual.origin);
  json["fitness"] = individual.fitness;
  json["trials"] = individual.trials;
  json["replay"] = replay_to_json(champion);
  json["genome"] = genome_to_json(individual.genome, heredity, owners);
  if (!champion.roster.empty())
    json["roster"] = roster_to_json(champion.roster, heredity, owners, champion.own_seat);
  json["states"] = champion.life.states;
  json["steps"] = steps_to_json(champion.life);
  return to_text(json);
}

Champion parse_champion(std::string_view text, const std::string& origin,
                        const evolution::Heredity& heredity, const GenomeOwners& owners) {
  const Json json = parse_json(text, origin);
  const JsonView view(json, origin);
  if (view.member("format").text() != champion_format)
    throw UsageError(origin + ": format is \"" + std::string(view.member("format").text()) +
                     "\", expected \"" + std::string(champion_format) + "\"");

  Champion champion;
  champion.experiment = view.member("experiment").text();
  champion.generation = view.member("generation").natural();
  if (view.has("population")) champion.population = natural32(view.member("population"));
  champion.individual = individual_from_json(view);
  ReadGenome read = genome_from_json(view.member("genome"), heredity, owners);
  champion.individual.genome = std::move(read.genome);
  champion.genes_match_bytes = read.matches_bytes;
  if (view.has("roster")) read_roster(view.member("roster"), heredity, owners, champion);

  const JsonView& replay = view.member("replay");
  champion.seed = replay.member("seed").key64();
  LifeRecord& life = champion.life;
  life.outcome = outcome_from_json(replay);
  life.score = replay.member("score").number();
  const JsonView& states = view.member("states");
  for (std::size_t i = 0; i < states.size(); ++i) life.states.emplace_back(states.item(i).text());
  read_steps(view.member("steps"), life);
  return champion;
}

SavedGenome parse_genome(std::string_view text, const std::string& origin,
                         const evolution::Heredity& heredity, const GenomeOwners& owners) {
  const Json json = parse_json(text, origin);
  const JsonView view(json, origin);
  ReadGenome read =
      genome_from_json(view.has("genome") ? view.member("genome") : view, heredity, owners);
  SavedGenome saved{std::move(read.genome), std::move(read.other_versions)};
  if (!read.matches_bytes) saved.warnings.push_back(edited_warning(origin));
  return saved;
}

}  // namespace somas::run
