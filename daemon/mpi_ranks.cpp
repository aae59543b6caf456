#include "daemon/mpi_ranks.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

#ifdef TISSUED_MPI
// Only C: the old C++ bindings need a library of their own.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>
#endif

namespace tissued::daemon {

#ifdef TISSUED_MPI

namespace {

// Open MPI's, and that of MPICH and its kin: without mpirun there is no need to start MPI at all.
bool is_started_by_mpirun() {
  return std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr || std::getenv("PMI_SIZE") != nullptr;
}

}  // namespace

MpiRanks::MpiRanks() {
  if (!is_started_by_mpirun()) return;
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  is_mpi_ = true;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  MPI_Comm machine;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Comm_size(machine, &on_this_machine_);
  MPI_Comm_free(&machine);
}

MpiRanks::~MpiRanks() {
  if (is_mpi_) MPI_Finalize();
}

void MpiRanks::send(int to, const std::string& text) const {
  MPI_Send(text.data(), static_cast<int>(text.size()), MPI_BYTE, to, 0, MPI_COMM_WORLD);
}

std::optional<MpiRanks::Message> MpiRanks::poll() const {
  if (!is_mpi_) return std::nullopt;
  int has_arrived = 0, size = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &has_arrived, &status);
  if (has_arrived == 0) return std::nullopt;
  MPI_Get_count(&status, MPI_BYTE, &size);
  Message message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(size), '\0')};
  MPI_Recv(message.text.data(), size, MPI_BYTE, message.from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return message;
}

#else

MpiRanks::MpiRanks() = default;
MpiRanks::~MpiRanks() = default;
void MpiRanks::send(int, const std::string&) const {}
std::optional<MpiRanks::Message> MpiRanks::poll() const { return std::nullopt; }

#endif

int MpiRanks::processors() const {
  const int bound = static_cast<int>(std::thread::hardware_concurrency());
  const int share = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)) / on_this_machine_;
  return std::max(1, std::min(bound, share));
}

}  // namespace tissued::daemon
