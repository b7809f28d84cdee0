#pragma once

#include <set>

#include "idl/datagrams/datagram_filter.h"

namespace handgraft::idl::cyclone {

/// From now on what Cyclone DDS receives in this process for `domain` goes through a
/// DatagramFilter first. Cyclone offers no place for that: its library's import of `recvmsg` is
/// pointed at a function of ours, before its first socket is there. Nothing else in the process
/// is touched, also not where the library was loaded along with a Python module.
///
/// A program that stood still for longer than 10 s (SIGSTOP, a machine that slept) also leaves
/// out for a moment what waited for it; why so: the source.
///
/// False if Cyclone's library was not found, or reads by other means: then nothing is filtered.
/// Threads: any. Cost: a look at the process' libraries, once; two system calls a datagram in
/// place of one.
bool gateDatagrams(int domain, DatagramFilter::Domain kind);

/// Of a gate that is there: whether clients are met.
void passOverClients(int domain, bool are_passed_over);

/// Of a gate that is there: whose identities were revoked; nothing that they say goes on.
void refuse(int domain, std::set<DatagramFilter::GuidBegin> whom);

}  // namespace handgraft::idl::cyclone
