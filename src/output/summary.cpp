#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "output/error_table.hpp"
#include "output/record.hpp"

namespace trefoil {
namespace {

using Json = nlohmann::ordered_json;

__attribute__((format(printf, 1, 2))) std::string text_of(const char *format, ...) {
  char text[512];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

double number(const Json &value) {
  return value.is_number() ? value.get<double>() : std::nan("");
}

std::string counted(int count, const char *thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

std::string vector_text(const Json &vector) {
  return text_of("(%.6g, %.6g, %.6g)", number(vector[0]), number(vector[1]), number(vector[2]));
}

std::string place_text(const Json &extreme) {
  return text_of("%.6g at ", number(extreme["value"])) + vector_text(extreme["at"]);
}

/// "converged in 5 iterations, 6 line-search trials: why", and what makes it doubtful.
std::string verdict(const Json &record) {
  const Json &result = record["result"];
  const int inverted = result["inverted"];
  std::string text = result["converged"].get<bool>() ? "converged in " : "NOT CONVERGED in ";
  text += counted(result["iterations"], "iteration") + ", " +
          counted(result["line_search_trials"], "line-search trial") + ": " +
          result["reason"].get<std::string>();
  if (inverted > 0) {
    text += "; WARNING: " + counted(inverted, "element") +
            (inverted == 1 ? " is inverted" : " are inverted");
  }
  if (const int halvings = result.value("path_halvings", 0); halvings > 0) {
    text += "; WARNING: the path of its loads was halved down, " + counted(halvings, "time") +
            ": there may be other equilibria";
  }
  if (result.value("energy_is_made", false)) {
    text += text_of("; WARNING: the total energy has risen by %.0f %% of its scale from nothing: ",
                    100 * number(result["energy_rise"])) +
            "-time_integrator bdf2 and backward_euler damp, or a shorter -time_step is needed";
  }
  if (result.value("friction_is_late", false)) {
    text += text_of(
                "; WARNING: friction lags: with its own state's normal forces it would differ "
                "by %.0f %%: ",
                100 * number(result["friction_lag"])) +
            result["friction_advice"].get<std::string>();
  }
  if (result.contains("balance_warning")) {
    text += "; WARNING: " + result["balance_warning"].get<std::string>();
  }
  const bool in_time = result.contains("kinetic_energy");  // each step is near its own minimum
  if (result["converged"].get<bool>() && result["minimum"].is_null() && !in_time) {
    text += "; unverified: whether this is a minimum is not known";
  }
  return text + "\n";
}

std::string energies(const Json &result) {
  std::string text =
      text_of("energy %.14g, gradient norm %.3g, inverted elements %d\n", number(result["energy"]),
              number(result["gradient_norm"]), result["inverted"].get<int>());
  if (result.contains("strain_energy")) {
    text += text_of("strain energy %.10g, work of the loads %.10g\n",
                    number(result["strain_energy"]), number(result["load_work"]));
  }
  if (result.contains("kinetic_energy")) {
    text += text_of("at t = %.6g: kinetic energy %.10g, momentum ", number(result["t"]),
                    number(result["kinetic_energy"])) +
            vector_text(result["momentum"]) + ", angular momentum " +
            vector_text(result["angular_momentum"]) + "\n";
  }
  const double scale = number(result["energy_scale"]);
  const bool at_minimum = result["minimum"].is_boolean() && result["minimum"].get<bool>();
  if (result["error_estimate"].is_number() && scale > 0) {
    text += text_of("solver's estimate of the relative energy error %.1e%s\n",
                    number(result["error_estimate"]) / scale,
                    at_minimum ? ", at a minimum: the Hessian is positive definite" : "");
  } else if (scale == 0) {
    text += "nothing is strained: there is no energy to compare an error with\n";
  }
  return text;
}

/// Reactions, forces, and what the body does.
std::string results(const Json &record) {
  const Json &result = record["result"];
  std::string text;
  for (const Json &constraint : record["constraints"]) {
    text += constraint["name"].get<std::string>() + ": reaction " +
            vector_text(constraint["reaction"]) + ", moment " + vector_text(constraint["moment"]) +
            "\n";
  }
  for (const Json &load : record["loads"]) {
    text += load["name"].get<std::string>() + ": force " + vector_text(load["force"]) + "\n";
  }
  if (result.contains("contact_forces")) {
    for (const auto &[name, force] : result["contact_forces"].items()) {
      text += name + ": contact force " + vector_text(force) + "\n";
    }
  }
  if (result.contains("probes")) {
    for (const auto &[name, displacement] : result["probes"].items()) {
      text += name + ": displacement " + vector_text(displacement) + "\n";
    }
  }
  if (result.contains("largest_displacement")) {
    text += "largest displacement " + place_text(result["largest_displacement"]) + "\n";
    text += "largest von Mises stress " + place_text(result["largest_von_mises"]) + "\n";
    text += "least det F " + place_text(result["least_det_F"]) +
            text_of("; volume %.8g\n", number(result["volume"]));
  }
  return text;
}

std::string times(const Json &time) {
  std::string text = text_of("seconds %.3g:", number(time["total"]));
  for (const char *phase : {"read", "setup", "guess", "assembly", "filter", "linear_solve",
                            "line_search", "output", "other"}) {
    text += text_of(" %s %.3g", phase, number(time[phase]));
  }
  return text + "\n";
}

}  // namespace

std::string summary_of(const Json &record) {
  const Json &result = record["result"];
  return verdict(record) + energies(result) + text_of_error_table(result["error_table"]) +
         results(record) + times(record["time"]);
}

}  // namespace trefoil
