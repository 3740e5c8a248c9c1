#include "core/run/manifest.hpp"

#include <fstream>

#include <gnu/libc-version.h>
#include <sys/utsname.h>

#include "somas/sdk/abi.hpp"

#include "core/run/build_info.hpp"
#include "core/run/files.hpp"

namespace somas::run {
namespace {

Json build_to_json() {
  const BuildInfo& build = build_info();
  Json json;
  json["compiler"] = build.compiler;
  json["type"] = build.build_type;
  json["flags"] = build.flags;
  json["architecture"] = build.architecture;
  json["sanitizers"] = build.sanitizers;
  json["fingerprint"] = SOMAS_FINGERPRINT;
  return json;
}

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

// What the arithmetic of a binary, or a library that chooses kernels, could depend on.
Json processor_features() {
  Json features = Json::array();
#if defined(__x86_64__)
#define SOMAS_FEATURE_(name) \
  if (__builtin_cpu_supports(name)) features.push_back(name)
  __builtin_cpu_init();
  SOMAS_FEATURE_("sse3");
  SOMAS_FEATURE_("ssse3");
  SOMAS_FEATURE_("sse4.1");
  SOMAS_FEATURE_("sse4.2");
  SOMAS_FEATURE_("avx");
  SOMAS_FEATURE_("avx2");
  SOMAS_FEATURE_("bmi2");
  SOMAS_FEATURE_("fma");
  SOMAS_FEATURE_("avx512f");
  SOMAS_FEATURE_("avx512dq");
  SOMAS_FEATURE_("avx512vl");
#undef SOMAS_FEATURE_
#endif
  return features;
}

Json system_to_json() {
  Json json;
  utsname system{};
  if (::uname(&system) == 0) {
    json["kernel"] = std::string(system.sysname) + " " + system.release;
    json["machine"] = system.machine;
  }
  json["libc"] = std::string("glibc ") + ::gnu_get_libc_version();
  json["processor"] = processor_name();
  json["features"] = processor_features();
  return json;
}

Json plugins_to_json(const experiment::Experiment& experiment) {
  Json list = Json::array();
  for (const experiment::Experiment::Library& library : experiment.libraries) {
    Json json;
    json["id"] = library.plugin_id;
    json["version"] = library.version;
    json["file"] = library.file.string();
    json["xxh3_128"] = hash_of_file(library.file);
    json["fingerprint"] = library.fingerprint;
    json["classes"] = library.classes;
    list.push_back(std::move(json));
  }
  return list;
}

Json genomes_to_json(const std::vector<GivenGenome>& genomes) {
  Json list = Json::array();
  for (const GivenGenome& genome : genomes) {
    Json json;
    json["file"] = genome.file.string();
    json["xxh3_128"] = hash_of_file(genome.file);
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace

Json manifest_of(const experiment::Experiment& experiment, const Request& request) {
  Json json;
  json["format"] = "somas-run/1";
  json["experiment"] = experiment.name;
  json["file"] = request.file.string();
  json["seed"] = experiment.seed;
  json["objective"] = experiment.ecosystem->fitness().objective();
  json["command_line"] = request.command_line;
  json["somas"] = build_info().version;
  json["host_xxh3_128"] = hash_of_file("/proc/self/exe");
  json["build"] = build_to_json();
  json["system"] = system_to_json();
  json["plugins"] = plugins_to_json(experiment);
  json["plugin_path"] = Json::array();
  for (const std::filesystem::path& directory : request.plugin_path)
    json["plugin_path"].push_back(std::filesystem::absolute(directory).lexically_normal().string());
  json["genomes"] = genomes_to_json(request.genomes);
  return json;
}

std::vector<std::filesystem::path> plugin_path_of(const Json& manifest, const std::string& origin) {
  const JsonView view(manifest, origin);
  const JsonView& list = view.member("plugin_path");
  std::vector<std::filesystem::path> directories;
  for (std::size_t i = 0; i < list.size(); ++i) directories.emplace_back(list.item(i).text());
  return directories;
}

std::vector<std::string> changed_plugins(const Json& manifest, const std::string& origin,
                                         const experiment::Experiment& now) {
  const JsonView view(manifest, origin);
  const JsonView& plugins = view.member("plugins");
  std::vector<std::string> changes;
  for (const experiment::Experiment::Library& library : now.libraries) {
    bool known = false;
    for (std::size_t i = 0; i < plugins.size(); ++i) {
      const JsonView& recorded = plugins.item(i);
      if (recorded.member("id").text() != library.plugin_id) continue;
      known = true;
      const std::string hash = hash_of_file(library.file);
      if (recorded.member("xxh3_128").text() == hash) continue;
      changes.push_back("plugin " + library.plugin_id + " is not the file of the run: now " +
                        library.file.string() + ", version " + library.version + ", hash " + hash +
                        "; then version " + std::string(recorded.member("version").text()) +
                        ", hash " + std::string(recorded.member("xxh3_128").text()));
    }
    if (!known)
      changes.push_back("plugin " + library.plugin_id + " (" + library.file.string() +
                        ") was not part of the run");
  }
  return changes;
}

}  // namespace somas::run
