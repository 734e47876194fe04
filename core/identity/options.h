// Options of the linking of identities, table [identity].
#ifndef KINEGRAPH_CORE_IDENTITY_OPTIONS_H_
#define KINEGRAPH_CORE_IDENTITY_OPTIONS_H_

#include <cstdint>
#include <vector>

#include "core/base/options.h"

namespace kinegraph {

struct LinkOptions {
  bool link = false;  // graph mode; needs the whole recording

  // By how many nats (powers of e) the explanation with a join must exceed the
  // best one without it: 2 nats are odds of 7 to 1. Exceptions: linking.h.
  double min_margin = 2.0;
  // Absences up to this are bridged with motion and bones; 0: any [s].
  double max_absence_s = 0.0;

  // Hints; 0 and empty: unknown.
  int64_t people = 0;  // in the whole recording
  // Spheres in which people appear and disappear: x, y, z, r.
  std::vector<double> entries;

  // Constants, not keys [nats]: prior in favour of continuing as tracked, and
  // the penalty of appearing or disappearing outside the entries.
  double continuity = 4.0;
  double entry_penalty = 4.0;

  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_OPTIONS_H_
