#include "idl/cyclone/datagram_gate.h"

#include <array>
#include <atomic>
#include <cstring>
#include <ctime>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <link.h>
#include <netinet/in.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/base/network.h"
#include "idl/cyclone/domain.h"

namespace handgraft::idl::cyclone {

namespace {

// === The filters, one a domain

class Filters {
 public:
  void set(int domain, DatagramFilter::Domain kind) {
    const std::lock_guard lock(mutex_);
    Known& known = known_.at(static_cast<std::size_t>(domain));
    if (known.filter != nullptr && known.kind == kind) return;
    // The one before may be in use just now: kept.
    all_.push_back(std::make_unique<DatagramFilter>(kind, DatagramFilter::Reader::kCyclone));
    known.kind = kind;
    known.filter = all_.back().get();
  }

  void passOverClients(int domain, bool are_passed_over) {
    const std::lock_guard lock(mutex_);
    DatagramFilter* const filter = known_.at(static_cast<std::size_t>(domain)).filter;
    if (filter != nullptr) filter->passOverClients(are_passed_over);
  }

  void refuse(int domain, std::set<DatagramFilter::GuidBegin> whom) {
    const std::lock_guard lock(mutex_);
    DatagramFilter* const filter = known_.at(static_cast<std::size_t>(domain)).filter;
    if (filter != nullptr) filter->refuse(std::move(whom));
  }

  /// Of the domain whose port that is, RTPS 2.3, 9.6.1.1; else one of an open domain.
  DatagramFilter& of(unsigned port) {
    constexpr unsigned kFirst = 7400;
    constexpr unsigned kPortsOfADomain = 250;
    const std::size_t domain = (port - kFirst) / kPortsOfADomain;
    if (port < kFirst || domain >= known_.size()) return open_;
    DatagramFilter* filter = known_[domain].filter;
    return filter == nullptr ? open_ : *filter;
  }

 private:
  struct Known {
    DatagramFilter::Domain kind = DatagramFilter::Domain::kOpen;
    std::atomic<DatagramFilter*> filter{nullptr};
  };

  std::mutex mutex_;
  std::array<Known, kHighestDomain + 1> known_;
  std::vector<std::unique_ptr<DatagramFilter>> all_;
  DatagramFilter open_{DatagramFilter::Domain::kOpen, DatagramFilter::Reader::kCyclone};
};

/// Never destroyed: Cyclone's threads may outlive `main`.
Filters& filters() {
  static auto* const one = new Filters;
  return *one;
}

unsigned portOf(int socket) {
  sockaddr_in address{};
  socklen_t length = sizeof address;
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length) != 0) return 0;
  return ntohs(address.sin_port);
}

// === What waited while this process stood still

double secondsOf(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Who stood still for longer than a lease was dropped by the others. What they said before
/// then waits in its sockets; Cyclone would acknowledge it to who has just met it anew, and who
/// then takes all that was announced before for known: nothing would ever come again. So it is
/// left out, until Cyclone has dropped the others, too. Its leases do not run while the machine
/// sleeps, hence longer then.
class Awakening {
 public:
  /// True of what came from a time before. Threads: any.
  bool isOver() {
    const double now = secondsOf(CLOCK_MONOTONIC);
    const double slept = secondsOf(CLOCK_BOOTTIME) - now;  // in all, since the machine's start
    const double idle = now - last_.load();
    const double slept_since = slept - slept_.load();
    if (last_.load() > 0.0 && idle + slept_since > kHalfALease)
      deaf_until_ = now + (slept_since > kHalfALease ? kLeaseDuration + kMoment : kMoment);
    // In this order, so that no other thread finds neither.
    last_ = now;
    slept_ = slept;
    return now >= deaf_until_.load();
  }

 private:
  static constexpr double kHalfALease = 0.5 * kLeaseDuration;  // s
  static constexpr double kMoment = 0.5;                       // s

  std::atomic<double> last_{0.0};  ///< datagram
  std::atomic<double> slept_{0.0};
  std::atomic<double> deaf_until_{0.0};
};

Awakening& awakening() {
  static auto* const one = new Awakening;
  return *one;
}

/// In place of the system's, for Cyclone alone.
ssize_t receive(int socket, msghdr* message, int flags) {
  const ssize_t size = recvmsg(socket, message, flags);
  if (size <= 0 || message->msg_iovlen == 0 || message->msg_iov[0].iov_len == 0) return size;
  auto* bytes = static_cast<std::uint8_t*>(message->msg_iov[0].iov_base);
  thread_local std::vector<std::uint8_t> kept;
  std::span<const std::uint8_t> passed;
  if (awakening().isOver() &&
      message->msg_iovlen == 1)  // one piece, as Cyclone always asks for
    passed = filters().of(portOf(socket)).pass({bytes, static_cast<std::size_t>(size)}, kept);
  if (passed.empty()) {
    // Too short for a header, it is left alone; none at all would be written to the log.
    bytes[0] = 0;
    return 1;
  }
  std::memmove(bytes, passed.data(), passed.size());
  return static_cast<ssize_t>(passed.size());
}

// === The import: a slot that the loader filled (System V ABI, chapter 5)

constexpr const char* kLibrary = "libddsc.so";
constexpr std::string_view kImport = "recvmsg";

#if __ELF_NATIVE_CLASS == 64
constexpr auto symbolOf(const ElfW(Rela) & one) {
  return ELF64_R_SYM(one.r_info);
}
#else
constexpr auto symbolOf(const ElfW(Rela) & one) {
  return ELF32_R_SYM(one.r_info);
}
#endif

struct Tables {
  const ElfW(Sym) * symbols = nullptr;
  const char* names = nullptr;
  const ElfW(Rela) * calls = nullptr;
  std::size_t calls_bytes = 0;
  const ElfW(Rela) * others = nullptr;
  std::size_t others_bytes = 0;
  std::uintptr_t protected_begin = 0;  ///< once the loader is done
  std::uintptr_t protected_end = 0;
};

/// What the loader was told: a list that ends with DT_NULL.
void readDynamic(const ElfW(Dyn) * at, Tables& tables) {
  bool has_addends = true;
  for (; at->d_tag != DT_NULL; ++at) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): the loader tells addresses as numbers.
    const auto* pointer = reinterpret_cast<const void*>(at->d_un.d_ptr);
    switch (at->d_tag) {
      case DT_SYMTAB:
        tables.symbols = static_cast<const ElfW(Sym)*>(pointer);
        break;
      case DT_STRTAB:
        tables.names = static_cast<const char*>(pointer);
        break;
      case DT_JMPREL:
        tables.calls = static_cast<const ElfW(Rela)*>(pointer);
        break;
      case DT_PLTRELSZ:
        tables.calls_bytes = at->d_un.d_val;
        break;
      case DT_RELA:
        tables.others = static_cast<const ElfW(Rela)*>(pointer);
        break;
      case DT_RELASZ:
        tables.others_bytes = at->d_un.d_val;
        break;
      case DT_PLTREL:
        has_addends = at->d_un.d_val == DT_RELA;
        break;
      default:
        break;
    }
  }
  if (!has_addends) tables.calls_bytes = 0;
}

Tables tablesOf(const dl_phdr_info& library) {
  Tables tables;
  for (int i = 0; i < library.dlpi_phnum; ++i) {
    const auto& segment = library.dlpi_phdr[i];
    const std::uintptr_t begin = library.dlpi_addr + segment.p_vaddr;
    if (segment.p_type == PT_GNU_RELRO) {
      tables.protected_begin = begin;
      tables.protected_end = begin + segment.p_memsz;
    }
    if (segment.p_type == PT_DYNAMIC)
      // NOLINTNEXTLINE(performance-no-int-to-ptr): the loader tells addresses as numbers.
      readDynamic(reinterpret_cast<const ElfW(Dyn)*>(begin), tables);
  }
  return tables;
}

bool write(const Tables& tables, void** slot, void* value) {
  const auto size = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const std::uintptr_t page = reinterpret_cast<std::uintptr_t>(slot) / size * size;
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the loader tells addresses as numbers.
  auto* const begin = reinterpret_cast<void*>(page);
  if (mprotect(begin, size, PROT_READ | PROT_WRITE) != 0) return false;
  __atomic_store_n(slot, value, __ATOMIC_RELEASE);
  // Elsewhere its neighbours may be slots that the loader still has to fill.
  const auto at = reinterpret_cast<std::uintptr_t>(slot);
  if (at >= tables.protected_begin && page + size <= tables.protected_end)
    mprotect(begin, size, PROT_READ);
  return true;
}

/// How many slots were pointed at ours.
int replaceIn(const dl_phdr_info& library) {
  const Tables tables = tablesOf(library);
  if (tables.symbols == nullptr || tables.names == nullptr) return 0;
  int count = 0;
  const auto look = [&](const ElfW(Rela) * entries, std::size_t bytes) {
    for (std::size_t i = 0; entries != nullptr && i < bytes / sizeof *entries; ++i) {
      const auto symbol = symbolOf(entries[i]);
      if (symbol == 0 || kImport != tables.names + tables.symbols[symbol].st_name) continue;
      // NOLINTNEXTLINE(performance-no-int-to-ptr): the loader tells addresses as numbers.
      auto** slot = reinterpret_cast<void**>(library.dlpi_addr + entries[i].r_offset);
      if (write(tables, slot, reinterpret_cast<void*>(&receive))) ++count;
    }
  };
  look(tables.calls, tables.calls_bytes);
  look(tables.others, tables.others_bytes);
  return count;
}

bool replaceImport() {
  int count = 0;
  dl_iterate_phdr(
      [](dl_phdr_info* library, std::size_t, void* into) {
        const std::string_view path = library->dlpi_name;
        if (path.find(kLibrary) != std::string_view::npos)
          *static_cast<int*>(into) += replaceIn(*library);
        return 0;
      },
      &count);
  return count > 0;
}

}  // namespace

bool gateDatagrams(int domain, DatagramFilter::Domain kind) {
  filters().set(domain, kind);
  static const bool is_replaced = replaceImport();
  return is_replaced;
}

void passOverClients(int domain, bool are_passed_over) {
  filters().passOverClients(domain, are_passed_over);
}

void refuse(int domain, std::set<DatagramFilter::GuidBegin> whom) {
  filters().refuse(domain, std::move(whom));
}

}  // namespace handgraft::idl::cyclone
