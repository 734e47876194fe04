// How the doctor says what it found.
#ifndef KINEGRAPH_SOLVERS_SCENE_DOCTOR_WORDS_H_
#define KINEGRAPH_SOLVERS_SCENE_DOCTOR_WORDS_H_

#include <cstddef>
#include <string>

namespace kinegraph {

// What is written beside the report, and how to use it.
inline constexpr char kUseCorrected[] = "--cameras=cameras.json of this report";

// `format` of printf, for up to three numbers.
std::string Format(const char* format, double a, double b = 0.0,
                   double c = 0.0);

// The confidence of each of `count` findings that fit equally. Sure things are
// 0.95, doubtful ones less, nothing is 1.
double Shared(double confidence, size_t count);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_DOCTOR_WORDS_H_
