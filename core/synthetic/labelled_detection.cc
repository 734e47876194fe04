#include "core/synthetic/labelled_detection.h"

namespace kinegraph {

// SplitMix64's finaliser (Steele, Lea and Flood 2014) over the four numbers.
uint64_t StreamSeed(int64_t seed, Stream stream, int a, int b) {
  uint64_t state = static_cast<uint64_t>(seed);
  for (const uint64_t part :
       {static_cast<uint64_t>(stream), static_cast<uint64_t>(a),
        static_cast<uint64_t>(b)}) {
    state += 0x9e3779b97f4a7c15ULL * (part + 1);
    state = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9ULL;
    state = (state ^ (state >> 27)) * 0x94d049bb133111ebULL;
    state ^= state >> 31;
  }
  return state;
}

}  // namespace kinegraph
