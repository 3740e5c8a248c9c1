#include "core/host/backend_choice.hpp"

#include "core/evaluation/cluster.hpp"
#include "core/evaluation/pool.hpp"

namespace somas::host {

std::unique_ptr<evaluation::Backend> make_backend(const BackendChoice& choice,
                                                  run::Terminal& terminal) {
  if (choice.threads != 0) return evaluation::thread_backend(choice.threads);
  if (choice.backend == "threads") return evaluation::thread_backend(choice.workers);
  evaluation::PoolOptions options;
  options.workers = choice.workers;
  options.memory_mib = choice.memory_mib;
  options.watchdog_seconds = static_cast<double>(choice.watchdog_seconds);
  options.warn = [&terminal](const std::string& text) { terminal.line("warning: " + text); };
  if (evaluation::Cluster* cluster = evaluation::Cluster::present())
    return cluster->backend(options);
  return std::make_unique<evaluation::Pool>(options);
}

}  // namespace somas::host
