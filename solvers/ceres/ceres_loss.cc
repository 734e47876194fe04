#include "solvers/ceres/ceres_loss.h"

namespace kinegraph {
namespace {

ceres::LossFunction* MakePlain(LossKind kind, double scale) {
  switch (kind) {
    case LossKind::kNone:
      break;
    case LossKind::kHuber:
      return new ceres::HuberLoss(scale);
    case LossKind::kCauchy:
      return new ceres::CauchyLoss(scale);
    case LossKind::kGemanMcClure:
      return new GemanMcClureLoss(scale);
    case LossKind::kTukey:
      return new ceres::TukeyLoss(scale);
  }
  return nullptr;
}

}  // namespace

void GemanMcClureLoss::Evaluate(double s, double rho[3]) const {
  const LossValue value = EvaluateLoss(LossKind::kGemanMcClure, scale_, s);
  rho[0] = value.rho;
  rho[1] = value.first;
  rho[2] = value.second;
}

ceres::LossFunction* MakeCeresLoss(LossKind kind, double scale,
                                   double information) {
  ceres::LossFunction* plain = MakePlain(kind, scale);
  if (information == 1.0) return plain;
  return new ceres::ScaledLoss(plain, information, ceres::TAKE_OWNERSHIP);
}

}  // namespace kinegraph
