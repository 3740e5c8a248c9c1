// The JSON Schema of experiment files against a validator of its own, and against the host.
#include "core/experiment/json_schema.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <random>
#include <regex>

#include <gmock/gmock.h>

#include "core/experiment/reader.hpp"
#include "core/plugins/yaml_text.hpp"
#include "tests/core/experiment/files.hpp"

namespace somas::experiment {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

const fs::path bundled = SOMAS_BINARY_DIR "/plugins";
const fs::path experiments = SOMAS_SOURCE_DIR "/experiments";

class Schema : public Files {
 protected:
  void SetUp() override {
    const plugins::Registry registry({{bundled, "test"}});
    if (registry.ids().empty()) GTEST_SKIP() << "built without the bundled plugins";
    write("schema.json", json_schema(registry));
  }

  // What the validator says of each file: "OK", or "path: fault".
  std::map<std::string, std::string> verdicts(const std::vector<fs::path>& files) const {
    std::string command = "/usr/bin/python3 '" SOMAS_SOURCE_DIR
                          "/tests/core/experiment/validate_yaml.py' '" +
                          (directory_ / "schema.json").string() + "'";
    for (const fs::path& file : files) command += " '" + file.string() + "'";
    FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
    std::map<std::string, std::string> verdicts;
    std::string line;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) {
      if (c != '\n') {
        line += static_cast<char>(c);
        continue;
      }
      const std::size_t end = line.find(' ');
      verdicts[line.substr(0, end)] = line.substr(end + 1);
      line.clear();
    }
    EXPECT_EQ(::pclose(pipe), 0) << "the validator needs python3-jsonschema and python3-yaml; "
                                 << (verdicts.empty() ? "" : verdicts.begin()->second);
    return verdicts;
  }

  // Empty: the host takes it.
  static std::string refusal(const fs::path& file) {
    try {
      static_cast<void>(load(file, {{}, {bundled}}));
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }
};

TEST_F(Schema, TakesEveryBundledExperiment) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(experiments))
    if (entry.path().extension() == ".yaml") {
      files.push_back(entry.path());
      const std::string resolved = load(entry.path(), {{}, {bundled}}).resolved_yaml;
      files.push_back(write("resolved_" + entry.path().filename().string(), resolved));
    }
  ASSERT_GE(files.size(), 20u);
  const auto said = verdicts(files);
  ASSERT_EQ(said.size(), files.size());
  for (const auto& [file, verdict] : said) EXPECT_EQ(verdict, "OK") << file;
}

const std::string whole =
    "controller: {plugin: grn}\nfitness: {plugin: survival_time}\n"
    "specialization: {plugin: tree, states: [{name: a}]}\n";

struct Bad {
  std::string text, path;
};

TEST_F(Schema, RefusesBadFilesAtTheRightPlace) {
  const std::vector<Bad> table = {
      {"wurld: {}\n" + whole, ": "},
      {"seed: -1\n" + whole, "seed: "},
      {"seed: x\n" + whole, "seed: "},
      {"somas: 2\n" + whole, "somas: "},
      {"name: ''\n" + whole, "name: "},
      {"plugins: here\n" + whole, "plugins: "},
      {"world: {radius: 0}\n" + whole, "world.radius: "},
      {"world: {radius: wide}\n" + whole, "world.radius: "},
      {"world: {max_steps: 1.5}\n" + whole, "world.max_steps: "},
      {"world: {raduis: 5}\n" + whole, "world: "},
      {"world: null\n" + whole, "world: "},
      {"world: {morphogens: {size: 64}}\n" + whole, "world.morphogens.size: "},
      {"world: {morphogens: {kinds: [{}, {evaporation: 2}]}}\n" + whole,
       "world.morphogens.kinds.1.evaporation: "},
      {"world: {morphogens: {deposit: peek}}\n" + whole, "world.morphogens.deposit: "},
      {"world: {strangers: {adhere: 1}}\n" + whole, "world.strangers.adhere: "},
      {"evolution: {mode: alone}\n" + whole, "evolution.mode: "},
      {"controller: {plugin: grn}\nfitness: {plugin: survival_time}\n", ": "},
      {"controller: {}\nfitness: {plugin: survival_time}\n"
       "specialization: {plugin: tree, states: [{name: a}]}\n",
       "controller: "},
      {"controller: {plugin: gnr}\nfitness: {plugin: survival_time}\n"
       "specialization: {plugin: tree, states: [{name: a}]}\n",
       "controller.plugin: "},
      {"controller: {plugin: grn, hidden: 3}\nfitness: {plugin: survival_time}\n"
       "specialization: {plugin: tree, states: [{name: a}]}\n",
       "controller: "},
      {"controller: {plugin: grn}\nfitness: {plugin: survival_time}\n"
       "specialization: {plugin: tree}\n",
       "specialization: "},
      {"controller: {plugin: grn}\nfitness: {plugin: survival_time}\n"
       "specialization: {plugin: tree, states: []}\n",
       "specialization.states: "},
      {"controller: {plugin: grn}\nfitness: {plugin: survival_time}\n"
       "specialization: {plugin: tree, states: [{mass: 2}]}\n",
       "specialization.states.0: "},
      {"controller: {plugin: grn}\nfitness: {plugin: survival_time}\n"
       "specialization: {plugin: tree, states: [{name: a, skills: {production: much}}]}\n",
       "specialization.states.0.skills.production: "},
      {"environments: {nutrients: {capacity: -1}}\n" + whole, "environments.nutrients.capacity: "},
      {"environments: {nutrients: null}\n" + whole, "environments.nutrients: "},
      {"environments: {food: {}}\n" + whole, "environments.food: "},
      {"environments: {food: {plugin: nutrients, capcity: 1}}\n" + whole, "environments.food: "},
      {"environments: {'my food': {plugin: nutrients}}\n" + whole, "environments: "},
      {"environments: {nutrients: {region: square}}\n" + whole, "environments.nutrients: "},
      {"environments: {nutrients: {radius: 5}}\n" + whole, "environments.nutrients: "},
      {"environments: {walls: {obstacles: [{kind: disc, x: 0, y: 0}]}}\n" + whole,
       "environments.walls.obstacles.0: "},
      {"extends: exp.yaml\ncontroller: {plugin: ctrnn, hidden: -1}\n", "controller.hidden: "},
      {"extends: exp.yaml\nenvironments: {nutrients: {colour: red}}\n", "environments.nutrients: "},
      {"extends: exp.yaml\nspecialization: {states: [{}]}\n", "specialization.states.0: "},
      {"extends: 5\n", "extends: "},
      {"replicates: 0\n" + whole, "replicates: "},
      {"sweep: [1]\n" + whole, "sweep: "},
      {"sweep: {seed: [1, 2]}\n" + whole, "sweep: "},
      {"sweep: {world.radius: []}\n" + whole, "sweep.world.radius: "},
      {"sweep: {world.radius: null}\n" + whole, "sweep.world.radius: "},
      {"sweep: {size: {small: {}, large: 3}}\n" + whole, "sweep.size.large: "},
  };
  fs::copy_file(experiments / "exp1.yaml", directory_ / "exp.yaml");
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < table.size(); ++i)
    files.push_back(write("bad" + std::to_string(i) + ".yaml", table[i].text));
  const auto said = verdicts(files);
  ASSERT_EQ(said.size(), files.size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    EXPECT_THAT(said.at(files[i].string()), StartsWith(table[i].path)) << table[i].text;
    EXPECT_NE(refusal(files[i]), "") << "the host takes it:\n" << table[i].text;
  }
}

TEST_F(Schema, TakesWhatAFileMayLeaveToTheOneItExtends) {
  fs::copy_file(experiments / "exp1.yaml", directory_ / "exp.yaml");
  write("poisoned.yaml", "extends: exp.yaml\nenvironments: {poison: {plugin: toxin_gradient}}\n");
  const std::string texts[] = {
      "extends: exp.yaml\n",
      "extends: exp.yaml\nspecialization: {budget: 20}\n",
      "extends: poisoned.yaml\nenvironments: {poison: null}\n",
      "extends: exp.yaml\ncontroller: {plugin: ctrnn}\n",
      "extends: exp.yaml\nenvironments: {more: {plugin: toxin_gradient}}\n",
      "extends: exp.yaml\nenvironments: {nutrients: {region: square, half_side: 9}}\n",
  };
  std::vector<fs::path> files;
  for (const std::string& text : texts)
    files.push_back(write("good" + std::to_string(files.size()) + ".yaml", text));
  for (const auto& [file, verdict] : verdicts(files)) {
    EXPECT_EQ(verdict, "OK") << file;
    EXPECT_EQ(refusal(file), "") << file;
  }
}

// ---- against the host --------------------------------------------------------------------------

// One line, as JSON; scalars as they stood.
std::string flow(const Node& node) {
  std::string text;
  switch (node.kind) {
    case Node::Kind::null:
      return "null";
    case Node::Kind::scalar:
      return node.quoted ? plugins::yaml_text(node.text) : node.text;
    case Node::Kind::sequence:
      for (const Node& item : node.items) text += (text.empty() ? "" : ", ") + flow(item);
      return "[" + text + "]";
    case Node::Kind::mapping:
      for (const Node& item : node.items)
        text += (text.empty() ? "" : ", ") + plugins::yaml_text(item.key) + ": " + flow(item);
      return "{" + text + "}";
  }
  return text;
}

void collect(Node& node, std::vector<Node*>& all) {
  for (Node& item : node.items) {
    all.push_back(&item);
    collect(item, all);
  }
}

Node value(const std::string& text) { return parse_value(text, {"mutation", 0, 0}); }

// Changes one place: another value, no value, another key, one key too many.
void mutate(Node& root, std::mt19937& random) {
  std::vector<Node*> all;
  collect(root, all);
  const auto below = [&](std::size_t n) { return random() % n; };
  Node& chosen = *all[below(all.size())];
  const std::string key = chosen.key;
  static const std::vector<std::string> values = {
      "0",     "-1",   "1",  "0.5",  "7",  "2.5",    "1000000000000", "-3e7", "1e-12",    "true",
      "false", "word", "''", "'12'", "[]", "[1, 2]", "[word]",        "{}",   "{odd: 1}", "null"};
  switch (below(4)) {
    case 0:
      chosen.key = key.empty() ? key : key + "_x";
      return;
    case 1:
      if (chosen.kind == Node::Kind::mapping)
        chosen.items.push_back(value("1")), chosen.items.back().key = "surplus";
      return;
    case 2: {
      // Deleted: its parent is found by asking everybody.
      for (Node* parent : all)
        if (!parent->items.empty() && &parent->items.front() <= &chosen &&
            &chosen <= &parent->items.back()) {
          const std::ptrdiff_t at = &chosen - &parent->items.front();
          parent->items.erase(parent->items.begin() + at);
          return;
        }
      return;
    }
    default: {
      Node other = value(values[below(values.size())]);
      other.key = key;
      chosen = std::move(other);
    }
  }
}

// What only the host can know; see json_schema.hpp.
bool is_beyond_a_schema(const std::string& refusal) {
  static const std::regex words(
      "has no meaning|but must be|is more than|is not less than|is the same as|no state is "
      "called|no state is the root|needs "
      "a parent|has the name|no skill is called|points; the budget|unstable|duplicate|is in charge|"
      "no environment has|would leave its range|is outside the world|is too small|is off the grid|"
      "allowed: at most|no morphogen|tournament|is taken by|the parents run|must lie within|"
      "is 0 in this experiment|another|already|there is no|at most|stable|expected an integer, "
      "found "
      "'[-+0-9.e]*'|produc|capacity|shape|kinds|a skill|name");
  return std::regex_search(refusal, words);
}

TEST_F(Schema, AgreesWithTheHostOnMutatedFiles) {
  std::mt19937 random(20141);
  std::vector<fs::path> files;
  for (const char* name : {"exp1", "exp2", "walls", "toxin_gradient", "competition",
                           "exp1_evolved_tree", "two_nutrients", "seasons"}) {
    const Node original = parse_yaml(
        load(experiments / (std::string(name) + ".yaml"), {{}, {bundled}}).resolved_yaml, name);
    for (int i = 0; i < 30; ++i) {
      Node mutant = original;
      mutate(mutant, random);
      files.push_back(write(name + std::to_string(i) + ".yaml", flow(mutant) + "\n"));
    }
  }
  const auto said = verdicts(files);
  ASSERT_EQ(said.size(), files.size());
  int taken = 0, refused = 0;
  for (const fs::path& file : files) {
    const std::string host = refusal(file), schema = said.at(file.string());
    if (schema != "OK") {
      EXPECT_NE(host, "") << "only the schema refuses " << read_text(file) << schema;
      ++refused;
    } else if (host.empty()) {
      ++taken;
    } else {
      EXPECT_TRUE(is_beyond_a_schema(host)) << "only the host refuses " << file << ": " << host;
    }
  }
  // The mutations say something of both sides.
  EXPECT_GT(taken, 30);
  EXPECT_GT(refused, 60);
}

}  // namespace
}  // namespace somas::experiment
