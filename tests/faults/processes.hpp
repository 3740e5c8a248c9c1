// Processes of this machine as /proc shows them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace somas::test {

/// Starts a program, a process group of its own, whose output is appended to `log`.
pid_t start(const std::vector<std::string>& words, const std::filesystem::path& log);

/// Direct children of all threads of a process, by their ids; none if it is gone.
std::vector<pid_t> children_of(pid_t process);

/// Is it there and not only waiting for its parent to notice its end?
bool alive(pid_t process);

/// The MPI rank of a process that a launcher has started; -1: none.
int rank_of(pid_t process);

/// What a coordinator is doing: its thread has the name of the phase. "start or end" outside all.
std::string phase_of(pid_t coordinator);

}  // namespace somas::test
