"""Run jobs in other processes and on other machines: isolated, limited, with nothing left over."""
