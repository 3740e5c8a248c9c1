#include <string>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/run/json.hpp"
#include "core/run/store.hpp"
#include "core/run/store_export.hpp"
#include "core/run/task_key.hpp"

namespace somas::host {

int execute(const DumpCommand& command, run::Terminal&) {
  const run::Store store(command.run / run::store_name, run::Database::Access::read);
  if (!command.hash) {
    run::dump(store.database(), [](std::string_view piece) { print(std::string(piece)); });
    return exit_ok;
  }
  run::Hasher hasher;
  run::dump(store.database(), [&](std::string_view piece) { hasher.add(piece); });
  print(run::hex_bytes(hasher.key()) + "\n");
  return exit_ok;
}

}  // namespace somas::host
