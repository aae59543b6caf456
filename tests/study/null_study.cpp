// Diagnoses sessions in which nothing is missing, and counts how often something is found all the same.
// usage: null_study COUNT SEED OUT.csv [SESSIONS AT A TIME]        run by scripts/nulls
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <mutex>
#include <set>
#include <thread>

#include "tests/study/null_summary.hpp"

namespace {

using namespace tissued::study;

// The rows of these seeds, each written as soon as it is known; by so many threads, one session each.
std::vector<NullRow> study(const std::vector<std::uint64_t>& seeds, int threads, std::ostream& out) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<NullRow> rows;
  std::exception_ptr failure;
  std::mutex mutex;
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < seeds.size(); i = next++) try {
        NullRow row = study_null(seeds[i]);
        const std::lock_guard lock(mutex);
        write_row(row, out);
        rows.push_back(std::move(row));
        const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        const auto done = static_cast<double>(rows.size()), left = static_cast<double>(seeds.size() - rows.size());
        std::fprintf(stderr, "%zu of %zu, about %.0f min left: seed %llu %s %s\n", rows.size(), seeds.size(),
                     elapsed / done * left / 60.0, static_cast<unsigned long long>(seeds[i]),
                     rows.back().text("verdict").c_str(), rows.back().text("findings").c_str());
      } catch (...) {
        const std::lock_guard lock(mutex);
        failure = std::current_exception();
        next = seeds.size();
      }
  };
  {
    std::vector<std::jthread> helpers;
    for (int k = 1; k < threads; ++k) helpers.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
  return rows;
}

int run(int count, std::uint64_t seed, const std::string& file, int threads) {
  std::vector<NullRow> rows = read_rows(file);
  // Written anew: an interrupted study may have left half a line.
  std::ofstream out(file);
  if (!out) throw std::runtime_error(file + ": cannot be written");
  write_header(out);
  for (const NullRow& row : rows) write_row(row, out);
  std::set<std::uint64_t> known;
  std::erase_if(rows, [&](const NullRow& row) {
    return row.seed < seed || row.seed >= seed + static_cast<std::uint64_t>(count) || !known.insert(row.seed).second;
  });
  std::vector<std::uint64_t> missing;
  for (std::uint64_t k = seed; k < seed + static_cast<std::uint64_t>(count); ++k)
    if (!known.contains(k)) missing.push_back(k);
  for (NullRow& row : study(missing, threads, out)) rows.push_back(std::move(row));
  std::sort(rows.begin(), rows.end(), [](const NullRow& a, const NullRow& b) { return a.seed < b.seed; });
  summarise(rows, std::cout);
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 4 || count > 5) {
    std::fprintf(stderr, "usage: null_study COUNT SEED OUT.csv [SESSIONS AT A TIME]\n");
    return 2;
  }
  try {
    const int threads = count == 5 ? std::stoi(arguments[4]) : static_cast<int>(std::thread::hardware_concurrency());
    return run(std::stoi(arguments[1]), std::stoull(arguments[2]), arguments[3], std::max(1, threads));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "null_study: %s\n", error.what());
    return 1;
  }
}
