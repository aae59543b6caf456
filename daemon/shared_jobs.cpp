#include "daemon/shared_jobs.hpp"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace tissued::daemon {
namespace {

using nlohmann::json;

constexpr int kNoMore = -1;
constexpr std::chrono::milliseconds kBetweenLooks{20};

struct Done {
  int number = kNoMore;  // kNoMore: the first call of a worker that has done nothing yet
  json result;
};

// Threads of this rank; each asks for work, does it, and asks again.
class Workers {
 public:
  Workers(int count, const std::function<json(int)>& job) : job_(&job) {
    for (int i = 0; i < count; ++i) {
      asking_.push_back({});
      threads_.emplace_back([this] { work(); });
    }
  }

  // A worker that is free, with what it did last; nothing where all are busy after a short wait.
  std::optional<Done> next_free() {
    std::unique_lock lock(mutex_);
    if (!free_.wait_for(lock, kBetweenLooks, [this] { return !asking_.empty(); })) return std::nullopt;
    Done done = std::move(asking_.front());
    asking_.pop_front();
    return done;
  }
  // To one that next_free told of; kNoMore ends it.
  void give(int number) {
    const std::lock_guard lock(mutex_);
    given_.push_back(number);
    work_.notify_one();
  }

 private:
  void work() {
    for (;;) {
      std::unique_lock lock(mutex_);
      work_.wait(lock, [this] { return !given_.empty(); });
      const int number = given_.front();
      given_.pop_front();
      if (number == kNoMore) return;
      lock.unlock();
      json result = (*job_)(number);
      lock.lock();
      asking_.push_back({number, std::move(result)});
      free_.notify_one();
    }
  }

  const std::function<json(int)>* job_;
  std::mutex mutex_;
  std::condition_variable free_, work_;
  std::deque<Done> asking_;
  std::deque<int> given_;
  std::vector<std::jthread> threads_;  // last: ended before what they use
};

// Whatever a file's name or an error's words hold.
std::string text_of(const json& message) { return message.dump(-1, ' ', false, json::error_handler_t::replace); }

// On every rank but 0: passes on what its workers ask, and what rank 0 answers.
void serve(const MpiRanks& ranks, int workers, const std::function<json(int)>& job) {
  Workers own(workers, job);
  ranks.send(0, text_of({{"workers", workers}}));
  int left = workers;
  while (left > 0) {
    if (const std::optional<Done> done = own.next_free())
      ranks.send(0, text_of({{"number", done->number}, {"result", done->result}}));
    while (left > 0) {  // what comes later is no answer of this call's
      const auto answer = ranks.poll();
      if (!answer) break;
      const int number = json::parse(answer->text).get<int>();
      own.give(number);
      if (number == kNoMore) --left;
    }
  }
}

}  // namespace

json share_jobs(const MpiRanks& ranks, int count, int workers, const std::function<json(int)>& job,
                const std::function<void(int, const json&)>& on_done, const std::function<bool()>& should_stop) {
  if (ranks.rank() != 0) {
    serve(ranks, workers, job);
    return {};
  }
  json results = json::array();
  for (int i = 0; i < count; ++i) results.push_back(nullptr);
  Workers own(workers, job);
  int next = 0;
  int left = workers, silent = ranks.size() - 1;  // workers to end, and ranks whose workers are not yet known
  const auto answer = [&](const Done& done) {
    if (done.number != kNoMore) {
      results[static_cast<std::size_t>(done.number)] = done.result;
      on_done(done.number, done.result);
    }
    const int number = next < count && !should_stop() ? next++ : kNoMore;
    if (number == kNoMore) --left;
    return number;
  };
  while (left > 0 || silent > 0) {
    if (const std::optional<Done> done = own.next_free()) own.give(answer(*done));
    while (const auto message = ranks.poll()) {
      const json told = json::parse(message->text);
      if (told.contains("workers")) {
        left += told.at("workers").get<int>();
        --silent;
      } else {
        ranks.send(message->from, std::to_string(answer({told.at("number"), told.at("result")})));
      }
    }
  }
  return results;
}

}  // namespace tissued::daemon
