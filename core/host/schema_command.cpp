#include "core/experiment/json_schema.hpp"
#include "core/experiment/loader.hpp"
#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/run/files.hpp"

namespace somas::host {

int execute(const SchemaCommand& command, run::Terminal&) {
  const plugins::Registry registry(experiment::search_path(command.plugin_path));
  const std::string schema = experiment::json_schema(registry);
  if (command.out) {
    run::check_output(*command.out);
    run::write_output(*command.out, schema);
  } else {
    print(schema);
  }
  return exit_ok;
}

}  // namespace somas::host
