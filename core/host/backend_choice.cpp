#include "core/host/backend_choice.hpp"

#include "core/evaluation/cluster.hpp"
#include "core/evaluation/pool.hpp"

namespace somas::host {

std::unique_ptr<evaluation::Backend> make_backend(const BackendChoice& choice,
                                                  run::Terminal& terminal) {
  evaluation::Cluster* cluster = evaluation::Cluster::present();
  if (choice.threads != 0 || choice.backend == "threads") {
    if (cluster != nullptr && cluster->size() > 1)
      terminal.line("warning: threads are of rank 0; the other ranks have nothing to do");
    return evaluation::thread_backend(choice.threads != 0 ? choice.threads : choice.workers,
                                      nullptr, {.threads = choice.world_threads});
  }
  evaluation::PoolOptions options;
  options.workers = choice.workers;
  options.world_threads = choice.world_threads;
  options.memory_mib = choice.memory_mib;
  options.watchdog_seconds = static_cast<double>(choice.watchdog_seconds);
  options.warn = [&terminal](const std::string& text) { terminal.line("warning: " + text); };
  if (cluster != nullptr) return cluster->backend(options);
  return std::make_unique<evaluation::Pool>(options);
}

}  // namespace somas::host
