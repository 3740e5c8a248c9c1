#include "core/evaluation/cluster.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <dlfcn.h>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <thread>
#include <unistd.h>
#include <utility>

#include <sys/prctl.h>

#include "core/evaluation/wire.hpp"

namespace somas::evaluation {
namespace {

using Clock = std::chrono::steady_clock;

/// MPI has nothing that a process could sleep on: we look, and sleep longer while nothing comes.
constexpr int shortest_sleep = 1, longest_sleep = 16;  // ms
constexpr std::chrono::seconds beat{1};
constexpr double longest_silence = 30;  // s

constexpr const char* rank_variables[] = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"};

/// The first byte between ranks.
enum class Word : std::uint8_t {
  // from rank 0
  setup,  ///< u64 places, u64 memory, f64 watchdog, u64 world threads
  start,  ///< u64 place, u64 life
  send,   ///< u64 place, text
  stop,   ///< u64 place
  quit,
  // to rank 0
  hello,    ///< u64 processors, text: machine
  message,  ///< u64 place, u64 life, text
  death,    ///< u64 place, u64 life, Death
  trouble,  ///< text: no process can be started
  alive,
};

void encode(Writer& out, const Death& death) {
  out.put(death.kind).text(death.cause).text(death.plugin);
  out.put(death.step.has_value()).put(death.step.value_or(0)).put(death.task);
}

Death decode_death(Reader& in) {
  Death death;
  death.kind = in.get<Death::Kind>();
  death.cause = in.text();
  death.plugin = in.text();
  const bool known = in.get<bool>();
  const auto step = in.get<std::uint64_t>();
  if (known) death.step = step;
  death.task = in.get<std::uint64_t>();
  return death;
}

std::string encoded(const Event& event) {
  Writer out;
  if (const auto* message = std::get_if<std::string>(&event.what)) {
    out.put(Word::message).put(std::uint64_t{event.place}).put(event.life).text(*message);
  } else {
    out.put(Word::death).put(std::uint64_t{event.place}).put(event.life);
    encode(out, std::get<Death>(event.what));
  }
  return out.take();
}

std::string host_name() {
  char name[256] = "";
  ::gethostname(name, sizeof name - 1);
  return name;
}

Transport* load_transport() {
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
  const std::filesystem::path file =
      (program.parent_path() / "../lib/somas/somas_mpi.so").lexically_normal();
  void* library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* why = ::dlerror();
    throw std::runtime_error(
        std::string("started by an MPI launcher, but MPI cannot be used: ") +
        (why != nullptr ? why : "unknown reason") +
        "; build it with libopenmpi-dev installed, or start one process without the launcher");
  }
  auto* entry = reinterpret_cast<TransportEntry*>(::dlsym(library, transport_entry));
  if (entry == nullptr)
    throw std::runtime_error(file.string() + " has no symbol " + transport_entry);
  return entry();
}

}  // namespace

/// Rank 0's letter box: what arrived from each rank, and when something last did.
class Cluster::Mail {
 public:
  explicit Mail(Transport& transport)
      : transport_(transport),
        boxes_(static_cast<std::size_t>(transport.size())),
        silence_(boxes_.size(), 0),
        names_(boxes_.size(), "a rank that has not answered") {}

  void send(std::size_t rank, std::string message) {
    transport_.send(static_cast<int>(rank), std::move(message));
  }

  /// All messages of a rank that have arrived. Throws EvaluatorsLost after a long silence.
  [[nodiscard]] std::vector<std::string> collect(std::size_t rank) {
    look();
    if (silence_[rank] > longest_silence) {
      lost_ = true;
      throw EvaluatorsLost("rank " + std::to_string(rank) + " (" + names_[rank] +
                           ") has not answered for " +
                           std::to_string(static_cast<int>(longest_silence)) + " s");
    }
    return std::exchange(boxes_[rank], {});
  }

  [[nodiscard]] int patience() const { return sleep_; }
  [[nodiscard]] bool lost() const { return lost_; }
  void set_lost() { lost_ = true; }
  void name(std::size_t rank, const std::string& name) { names_[rank] = name; }
  [[nodiscard]] const std::string& name_of(std::size_t rank) const { return names_[rank]; }

 private:
  void look() {
    // The time that we slept through, or were suspended for, is no silence of others.
    const Clock::time_point now = Clock::now();
    const double passed =
        std::min(0.5, std::chrono::duration<double>(now - std::exchange(looked_, now)).count());
    for (double& silence : silence_) silence += passed;
    bool any = false;
    int from = 0;
    for (std::string message; transport_.receive(from, message);) {
      const auto rank = static_cast<std::size_t>(from);
      silence_[rank] = 0;
      if (static_cast<Word>(message.at(0)) == Word::alive) continue;
      boxes_[rank].push_back(std::move(message));
      any = true;
    }
    sleep_ = any ? shortest_sleep : std::min(longest_sleep, 2 * sleep_);
  }

  Transport& transport_;
  std::vector<std::vector<std::string>> boxes_;
  std::vector<double> silence_;
  std::vector<std::string> names_;
  Clock::time_point looked_ = Clock::now();
  int sleep_ = shortest_sleep;
  bool lost_ = false;
};

namespace {

/// The evaluators of another rank.
class RemoteStation final : public Station {
 public:
  RemoteStation(std::shared_ptr<Cluster::Mail> mail, std::size_t rank, const LocalOptions& options)
      : mail_(std::move(mail)), rank_(rank), places_(options.places), name_(mail_->name_of(rank)) {
    Writer out;
    out.put(Word::setup).put(std::uint64_t{options.places}).put(options.memory_mib);
    out.put(options.watchdog_seconds).put(std::uint64_t{options.world_threads});
    mail_->send(rank_, out.take());
  }
  ~RemoteStation() override {
    for (std::size_t place = 0; place < places_; ++place) RemoteStation::stop(place);
  }
  RemoteStation(const RemoteStation&) = delete;
  RemoteStation& operator=(const RemoteStation&) = delete;

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] std::size_t places() const override { return places_; }
  void start(std::size_t place, std::uint64_t life) override {
    Writer out;
    mail_->send(rank_, out.put(Word::start).put(std::uint64_t{place}).put(life).take());
  }
  void send(std::size_t place, const std::string& message) override {
    Writer out;
    mail_->send(rank_, out.put(Word::send).put(std::uint64_t{place}).text(message).take());
  }
  void stop(std::size_t place) override {
    Writer out;
    mail_->send(rank_, out.put(Word::stop).put(std::uint64_t{place}).take());
  }

  void wait_for(std::vector<pollfd>&) const override {}
  [[nodiscard]] int patience() const override { return mail_->patience(); }

  void collect(std::vector<Event>& events) override {
    for (const std::string& message : mail_->collect(rank_)) {
      Reader in(message);
      const auto word = in.get<Word>();
      if (word == Word::trouble) throw EvaluatorsLost(name_ + ": " + std::string(in.text()));
      if (word != Word::message && word != Word::death) continue;
      Event event;
      event.place = in.get<std::uint64_t>();
      event.life = in.get<std::uint64_t>();
      if (word == Word::message)
        event.what = std::string(in.text());
      else
        event.what = decode_death(in);
      events.push_back(std::move(event));
    }
  }

 private:
  std::shared_ptr<Cluster::Mail> mail_;
  std::size_t rank_, places_;
  std::string name_;
};

/// What a rank does that supervises.
class Supervisor {
 public:
  explicit Supervisor(Transport& transport) : transport_(transport) {}

  void run() {
    Writer hello;
    hello.put(Word::hello).put(std::uint64_t{usable_processors()}).text(host_name());
    transport_.send(0, hello.take());
    while (!over_) {
      bool any = obey();
      any = report() || any;
      sleep_ = any ? shortest_sleep : std::min(longest_sleep, 2 * sleep_);
      if (Clock::now() - beaten_ > beat) {
        Writer out;
        transport_.send(0, out.put(Word::alive).take());
        beaten_ = Clock::now();
      }
      std::vector<pollfd> descriptors;
      if (station_) station_->wait_for(descriptors);
      ::poll(descriptors.data(), descriptors.size(), sleep_);
    }
  }

 private:
  bool obey() {
    bool any = false;
    int from = 0;
    for (std::string message; !over_ && transport_.receive(from, message); any = true) {
      try {
        obey(Reader(message));
      } catch (const EvaluatorsLost& error) {
        Writer out;
        transport_.send(0, out.put(Word::trouble).text(error.what()).take());
      }
    }
    return any;
  }

  void obey(Reader in) {
    const auto word = in.get<Word>();
    if (word == Word::quit) {
      over_ = true;
      station_.reset();
    } else if (word == Word::setup) {
      LocalOptions options;
      options.places = in.get<std::uint64_t>();
      options.memory_mib = in.get<std::uint64_t>();
      options.watchdog_seconds = in.get<double>();
      options.world_threads = static_cast<unsigned>(in.get<std::uint64_t>());
      station_ = local_station(options);
    } else if (station_) {
      const std::size_t place = in.get<std::uint64_t>();
      if (word == Word::start) station_->start(place, in.get<std::uint64_t>());
      if (word == Word::send) station_->send(place, std::string(in.text()));
      if (word == Word::stop) station_->stop(place);
    }
  }

  bool report() {
    if (!station_) return false;
    std::vector<Event> events;
    station_->collect(events);
    for (const Event& event : events) transport_.send(0, encoded(event));
    return !events.empty();
  }

  Transport& transport_;
  std::unique_ptr<Station> station_;
  int sleep_ = shortest_sleep;
  Clock::time_point beaten_ = Clock::now();
  bool over_ = false;
};

Cluster* the_cluster = nullptr;

}  // namespace

bool Cluster::launched() {
  return std::any_of(std::begin(rank_variables), std::end(rank_variables),
                     [](const char* name) { return std::getenv(name) != nullptr; });
}

int Cluster::expected_rank() {
  for (const char* name : rank_variables)
    if (const char* text = std::getenv(name))
      return static_cast<int>(std::strtol(text, nullptr, 10));
  return 0;
}

Cluster::Cluster() : transport_(load_transport()) {
  // A launcher that dies takes its ranks along; the coordinator saves what it has.
  ::prctl(PR_SET_PDEATHSIG, rank() == 0 ? SIGTERM : SIGKILL);
  if (rank() == 0) mail_ = std::make_shared<Mail>(*transport_);
  the_cluster = this;
}

Cluster::~Cluster() { the_cluster = nullptr; }

Cluster* Cluster::present() { return the_cluster; }
int Cluster::rank() const { return transport_->rank(); }
int Cluster::size() const { return transport_->size(); }

void Cluster::supervise() {
  // Launchers send signals to all ranks; rank 0 decides what becomes of the job.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGUSR1, SIGUSR2, SIGXCPU})
    std::signal(signal, SIG_IGN);
  Supervisor(*transport_).run();
  transport_->finish();
}

// Each rank says once who it is.
void Cluster::meet_ranks() {
  if (!names_.empty()) return;
  std::vector<std::string> names = {host_name()};
  std::vector<std::size_t> processors = {usable_processors()};
  for (std::size_t rank = 1; rank < static_cast<std::size_t>(size()); ++rank) {
    std::vector<std::string> messages;
    while ((messages = mail_->collect(rank)).empty())
      std::this_thread::sleep_for(std::chrono::milliseconds(mail_->patience()));
    Reader in(messages.front());
    static_cast<void>(in.get<Word>());
    processors.push_back(in.get<std::uint64_t>());
    names.emplace_back(in.text());
    mail_->name(rank, names.back());
  }
  names_ = std::move(names);
  processors_ = std::move(processors);
}

std::unique_ptr<Backend> Cluster::backend(const PoolOptions& options) {
  meet_ranks();
  std::vector<std::size_t> places = processors_;
  for (std::size_t& of_rank : places)
    of_rank = options.workers != 0 ? options.workers
                                   : std::max(std::size_t{1}, of_rank / options.world_threads);
  LocalOptions local{.places = 0,
                     .memory_mib = options.memory_mib,
                     .watchdog_seconds = options.watchdog_seconds,
                     .world_threads = options.world_threads,
                     .program = options.program};
  StationMaker make = [mail = mail_, places, local]() mutable {
    std::vector<std::unique_ptr<Station>> stations;
    for (std::size_t rank = 0; rank < places.size(); ++rank) {
      local.places = places[rank];
      if (rank == 0)
        stations.push_back(local_station(local));
      else
        stations.push_back(std::make_unique<RemoteStation>(mail, rank, local));
    }
    return stations;
  };
  return std::make_unique<Pool>(names_, std::move(places), std::move(make), options.warn,
                                options.world_threads);
}

void Cluster::end(int exit_code) {
  if (mail_->lost()) transport_->abort(exit_code);
  for (int rank = 1; rank < size(); ++rank) {
    Writer out;
    transport_->send(rank, out.put(Word::quit).take());
  }
  transport_->finish();
}

}  // namespace somas::evaluation
