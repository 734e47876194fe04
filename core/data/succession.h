// One track that begins with what another one left.
#ifndef KINEGRAPH_CORE_DATA_SUCCESSION_H_
#define KINEGRAPH_CORE_DATA_SUCCESSION_H_

#include "core/base/ids.h"
#include "core/base/time.h"

namespace kinegraph {

// In so many views the detections with which `to` began clearly go on from
// those that `from` had when it was lost.
struct Succession {
  TrackId from;
  TrackId to;
  int views = 0;
  TimeNs since =
      0;  // `from` had them without a break, in the best of the views
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_SUCCESSION_H_
