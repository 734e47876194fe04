// The tables of Chu et al. (2021) as they are printed.
#ifndef KINEGRAPH_APPS_TABLES_PUBLISHED_H_
#define KINEGRAPH_APPS_TABLES_PUBLISHED_H_

#include <string>
#include <vector>

namespace kinegraph {

// A line of a printed table. Cells are texts, so that "98" stays "98"; "-" is a
// cell that the paper leaves empty.
struct PublishedRow {
  std::string method;
  std::vector<std::string> cells;
};

struct PublishedTable {
  std::string caption;  // where in the paper, and what to know of it
  std::vector<std::string> columns;
  std::vector<PublishedRow> rows;
};

// PCP [%] of the paper's Actor1..3 (0..2 here) and their average.
PublishedTable PublishedCampus();
PublishedTable PublishedCampusExtended();
PublishedTable PublishedShelf();
// PCP [%] of upper and lower arms and legs.
PublishedTable PublishedCampusParts();
PublishedTable PublishedShelfParts();
// Milliseconds a frame by stage on Shelf, and frames a second.
PublishedTable PublishedRuntime();
// The ablation survives in sentences alone: its figure is not in the source.
PublishedTable PublishedAblation();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_PUBLISHED_H_
