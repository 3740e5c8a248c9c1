#!/usr/bin/env Rscript
# Reads a recording of SOMAS with hdf5r (Debian: r-cran-hdf5r).
#
# usage: read_recording.R FILE.h5
suppressPackageStartupMessages(library(hdf5r))

f <- H5File$new(commandArgs(trailingOnly = TRUE)[1], mode = "r")
column <- function(path) as.numeric(f[[path]][])
states <- f[["states/name"]][]
causes <- f[["names/causes"]][]
kinds <- f[["names/events"]][]
cat(sprintf("%s, generation %d, individual %d: %d steps\n", h5attr(f, "experiment"),
            as.integer(h5attr(f, "generation")), as.integer(h5attr(f, "individual")),
            as.integer(h5attr(f, "steps"))))

# A row per cell and frame. Numbers of states count from 0.
cells <- data.frame(step = column("cells/step"), state = column("cells/state"),
                    energy = column("cells/energy"))
last <- cells[cells$step == max(cells$step), ]
cat(sprintf("\ncells and mean energy at step %d\n", as.integer(max(cells$step))))
for (s in sort(unique(last$state)))
  cat(sprintf("  %s: %d %.4f\n", states[s + 1], sum(last$state == s),
              mean(last$energy[last$state == s])))

# What happened, at any step.
kind <- column("events/kind")
cause <- column("events/cause")
cat("\nevents\n")
for (k in seq_along(kinds)) cat(sprintf("  %s: %d\n", kinds[k], sum(kind == k - 1)))
cat("\ndeaths by cause\n")
deaths <- cause[kind == match("death", kinds) - 1]
for (c in sort(unique(deaths)))
  cat(sprintf("  %s: %d\n", if (c < length(causes)) causes[c + 1] else "wound", sum(deaths == c)))

# Ambrosia that passed between states, over the whole life.
flux <- data.frame(giver = column("flux/from_state"), receiver = column("flux/to_state"),
                   amount = column("flux/amount"))
cat("\nambrosia passed on\n")
if (nrow(flux) > 0) {
  sums <- aggregate(amount ~ receiver + giver, flux, sum)
  for (r in seq_len(nrow(sums)))
    cat(sprintf("  %s -> %s: %.3f\n", states[sums$giver[r] + 1], states[sums$receiver[r] + 1],
                sums$amount[r]))
}

# A grid. R turns the order of dimensions round: columns x rows x frames.
for (name in f[["names/grids"]][]) {
  content <- f[[paste0("grids/", name, "/content")]]
  size <- content$dims
  cat(sprintf("\n%s: %d x %d squares, %.4f on average at step %d\n", name, size[2], size[1],
              mean(content[, , size[3]]), as.integer(max(column("grids/step")))))
}
f$close_all()
