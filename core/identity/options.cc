#include "core/identity/options.h"

namespace kinegraph {

void LinkOptions::Describe(OptionVisitor& visitor) {
  visitor.Boolean("link", &link,
                  "graph mode: join tracks over the whole recording");
  visitor.Number("min_margin", &min_margin, NonNegative(), "nats",
                 "advantage over the second best that a change needs");
  visitor.Number("max_absence", &max_absence_s, NonNegative(), "s",
                 "longest absence that is joined; 0: any");
  visitor.Integer("people", &people, Between(0, 10000), "people",
                  "hint: people in the recording; 0: not known");
  visitor.NumberList("entries", &entries, Between(-1e6, 1e6), "m",
                     "hint: spheres where people come and go: x, y, z, radius "
                     "of each");
}

}  // namespace kinegraph
