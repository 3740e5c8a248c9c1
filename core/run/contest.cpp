#include "core/run/contest.hpp"

namespace somas::run {

using evolution::Source;

Contest::Contest(const evolution::Settings& settings, const evolution::Heredity& heredity,
                 std::uint64_t seed, std::uint64_t generation,
                 const std::vector<evolution::Population>& populations,
                 const std::vector<FormerChampion>& former)
    : populations_(populations),
      trials_(settings.trials),
      matches_(evolution::matches(settings, seed, generation)) {
  for (const evolution::HallMember& member : evolution::hall_of(settings, seed, generation)) {
    Rng rng(seed, 0, generation, stable_key("hall"), member.number);
    if (member.random)
      hall_.push_back({0, true, heredity.random(rng)});
    else
      hall_.push_back({former.at(member.number).id, false, former.at(member.number).genome});
  }

  for (const evolution::Population& population : populations_)
    parts_.emplace_back(population.size() * trials_);
  for (std::size_t m = 0; m < matches_.size(); ++m)
    for (std::size_t s = 0; s < matches_[m].seats.size(); ++s) {
      const evolution::Seat& seat = matches_[m].seats[s];
      if (seat.source == Source::hall) continue;
      parts_[static_cast<std::size_t>(seat.source)][seat.index * trials_ + matches_[m].trial] = {m,
                                                                                                 s};
    }
}

const model::Genome& Contest::genome_of(const evolution::Seat& seat) const {
  if (seat.source == Source::hall) return hall_[seat.index].genome;
  return populations_[static_cast<std::size_t>(seat.source)][seat.index].genome;
}

std::vector<evaluation::Task> Contest::tasks() const {
  std::vector<evaluation::Task> tasks;
  tasks.reserve(matches_.size());
  for (const evolution::Match& match : matches_) {
    evaluation::Task& task = tasks.emplace_back();
    task.seed = match.seed;
    for (const evolution::Seat& seat : match.seats) {
      task.roster.push_back({&genome_of(seat), seat.key, seat.x, seat.y});
      if (seat.source != evolution::Source::hall)
        task.predicted_cost += populations_[static_cast<std::size_t>(seat.source)][seat.index].cost;
    }
  }
  return tasks;
}

std::vector<RosterSeat> Contest::roster(std::size_t match) const {
  std::vector<RosterSeat> roster;
  const std::vector<evolution::Seat>& seats = matches_[match].seats;
  if (seats.size() < 2) return roster;
  for (const evolution::Seat& seat : seats) {
    RosterSeat& entry = roster.emplace_back();
    entry.key = seat.key;
    entry.x = seat.x;
    entry.y = seat.y;
    entry.genome = genome_of(seat);
    if (seat.source == Source::hall) {
      if (!hall_[seat.index].random) entry.id = hall_[seat.index].id;
      continue;
    }
    const auto population = static_cast<std::size_t>(seat.source);
    entry.id = populations_[population][seat.index].id;
    if (populations_.size() > 1) entry.population = static_cast<std::uint32_t>(population) + 1;
  }
  return roster;
}

std::string Contest::name_of(const evolution::Seat& seat) const {
  if (seat.source == Source::hall)
    return hall_[seat.index].random ? "random" : std::to_string(hall_[seat.index].id);
  const auto population = static_cast<std::size_t>(seat.source);
  const std::string id = std::to_string(populations_[population][seat.index].id);
  return populations_.size() > 1 ? std::to_string(population + 1) + ":" + id : id;
}

std::string Contest::opponents(std::size_t population, std::size_t index) const {
  std::string text;
  for (std::uint32_t trial = 0; trial < trials_; ++trial) {
    const Part own = part(population, index, trial);
    const std::vector<evolution::Seat>& seats = matches_[own.match].seats;
    std::string others;
    for (std::size_t s = 0; s < seats.size(); ++s)
      if (s != own.seat) others += (others.empty() ? "" : " ") + name_of(seats[s]);
    text += (trial == 0 ? "" : ";") + others;
  }
  return text;
}

}  // namespace somas::run
